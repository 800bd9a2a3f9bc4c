// A controller of ros2_control: reads stylus, grip force and travel of one finger, writes the force to hold with.
//
// The contract is that of controller_interface::ControllerInterface: on_configure() may allocate; on_activate(),
// update() and on_deactivate() run in the real-time loop and do not. Built and run in this project against the two
// headers in `test/mock` alone, which have what is used here and nothing else; never yet against ROS 2.
#include <slip.h>

#include <cstddef>
#include <limits>
#include <memory>
#include <string>

#include "controller_interface/controller_interface.hpp"
#include "pluginlib/class_list_macros.hpp"

namespace slip_grip {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;
using controller_interface::return_type;

// What a state interface has: get_optional() since Jazzy, get_value() before; NaN where it cannot be read now.
template <typename Interface>
auto reading(const Interface &state, int) -> decltype(static_cast<float>(state.get_optional().value())) {
  return static_cast<float>(state.get_optional().value_or(std::numeric_limits<double>::quiet_NaN()));
}
template <typename Interface>
auto reading(const Interface &state, long) -> decltype(static_cast<float>(state.get_value())) {
  return static_cast<float>(state.get_value());
}

class SlipGripController : public controller_interface::ControllerInterface {
 public:
  ~SlipGripController() override { slip_destroy(pipeline_); }

  // Parameters: the names of the interfaces.
  CallbackReturn on_init() override {
    command_ = auto_declare<std::string>("command", "finger/effort");
    stylus_ = auto_declare<std::string>("stylus", "stylus/displacement");
    force_ = auto_declare<std::string>("force", "finger/effort");
    travel_ = auto_declare<std::string>("travel", "object/travel");
    return CallbackReturn::SUCCESS;
  }

  InterfaceConfiguration command_interface_configuration() const override {
    return {interface_configuration_type::INDIVIDUAL, {command_}};
  }

  InterfaceConfiguration state_interface_configuration() const override {
    return {interface_configuration_type::INDIVIDUAL, {stylus_, force_, travel_}};
  }

  CallbackReturn on_configure(const rclcpp_lifecycle::State &) override {
    slip_destroy(pipeline_);
    pipeline_ = nullptr;
    memory_.reset(new std::byte[slip_size()]);
    slip_options options{};
    options.rate_hz = static_cast<float>(get_update_rate());
    options.control = 1;
    const slip_status status = slip_create(memory_.get(), slip_size(), &options, nullptr, 0, &pipeline_);
    return status == SLIP_STATUS_OK ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
  }

  // Closes the fingers again after a release; at first they close by themselves.
  CallbackReturn on_activate(const rclcpp_lifecycle::State &) override { return ask(SLIP_OPERATION_GRASP); }

  // Writes nothing: the fingers keep the last force until the next activation.
  CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) override { return ask(SLIP_OPERATION_RELEASE); }

  // A sample in, a force out. An error, also of a time that does not rise, leaves the command as it is: nothing here
  // opens the fingers.
  return_type update(const rclcpp::Time &time, const rclcpp::Duration &) override {
    const auto t_us = static_cast<uint64_t>(time.nanoseconds() / 1000);
    const auto stylus_m = reading(state_interfaces_[0], 0);
    const auto force_n = reading(state_interfaces_[1], 0);
    const auto travel_m = reading(state_interfaces_[2], 0);
    slip_block block{};
    block.rows = 1;
    block.t_us = &t_us;
    block.stylus = &stylus_m;
    block.normal_force_n = &force_n;
    block.travel_m = &travel_m;
    slip_result result{};
    if (slip_push(pipeline_, &block, &result) != SLIP_STATUS_OK) return return_type::ERROR;
    (void)command_interfaces_[0].set_value(static_cast<double>(result.state.command_n));
    return return_type::OK;
  }

 private:
  CallbackReturn ask(uint8_t operation) {
    return slip_command(pipeline_, operation, 0.0F) == SLIP_STATUS_OK ? CallbackReturn::SUCCESS : CallbackReturn::ERROR;
  }

  std::string command_, stylus_, force_, travel_;
  std::unique_ptr<std::byte[]> memory_;
  slip_pipeline *pipeline_ = nullptr;
};

}  // namespace slip_grip

PLUGINLIB_EXPORT_CLASS(slip_grip::SlipGripController, controller_interface::ControllerInterface)
