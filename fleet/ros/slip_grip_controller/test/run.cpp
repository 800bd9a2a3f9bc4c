// What a controller manager does with the controller, at a toy gripper whose object slips until it is held by 5 N.
#include <cstdio>
#include <memory>
#include <random>

#include "controller_interface/controller_interface.hpp"

std::unique_ptr<controller_interface::ControllerInterface> make_plugin();

int main() {
  using namespace controller_interface;
  double stylus_m = 0, force_n = 0, travel_m = 0, command_n = 0;
  const auto controller = make_plugin();
  for (double *value : {&stylus_m, &force_n, &travel_m}) controller->state_interfaces_.emplace_back(value);
  controller->command_interfaces_.emplace_back(&command_n);
  const rclcpp_lifecycle::State state;
  if (controller->on_init() != CallbackReturn::SUCCESS || controller->on_configure(state) != CallbackReturn::SUCCESS ||
      controller->on_activate(state) != CallbackReturn::SUCCESS ||
      controller->state_interface_configuration().names.size() != controller->state_interfaces_.size()) {
    return 1;
  }
  std::mt19937 random(3000);
  std::normal_distribution<double> noise(0.0, 1.0);
  double applied_n = 0;
  const int64_t period_ns = 1'000'000;
  for (int64_t at = 1; at <= 5000; ++at) {
    applied_n += 0.1 * (command_n - applied_n);
    const bool slides = at > 1500 && applied_n < 5.0;
    if (slides) travel_m += 10e-6;
    stylus_m = (slides ? 5e-6 : 5e-8) * noise(random);
    force_n = applied_n + 0.002 * noise(random);
    if (controller->update(rclcpp::Time(at * period_ns), rclcpp::Duration(period_ns)) != return_type::OK) return 1;
  }
  // A clock that stands: an error, and the force stays.
  const double last_n = command_n;
  if (controller->update(rclcpp::Time(5000 * period_ns), rclcpp::Duration(period_ns)) != return_type::ERROR ||
      command_n != last_n) {
    return 1;
  }
  std::printf("held with %.2f N, moved %.2f mm\n", applied_n, 1e3 * travel_m);
  const bool held = applied_n >= 5.0 && travel_m > 0.0;
  return !(held && controller->on_deactivate(state) == CallbackReturn::SUCCESS);
}
