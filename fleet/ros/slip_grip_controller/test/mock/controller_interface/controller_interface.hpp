// Not ros2_control: what the controller needs of it, so that it runs without ROS 2. Names and signatures are those of Jazzy, with HUMBLE those
// of Humble.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace rclcpp {
class Time {
 public:
  explicit Time(int64_t nanoseconds) : nanoseconds_(nanoseconds) {}
  int64_t nanoseconds() const { return nanoseconds_; }

 private:
  int64_t nanoseconds_;
};
using Duration = Time;
}  // namespace rclcpp

namespace rclcpp_lifecycle {
class State {};
}  // namespace rclcpp_lifecycle

namespace hardware_interface {
class LoanedInterface {
 public:
  explicit LoanedInterface(double *value) : value_(value) {}
#ifdef HUMBLE
  double get_value() const { return *value_; }
  void set_value(double value) { *value_ = value; }
#else
  template <typename T = double>
  std::optional<T> get_optional(unsigned = 10) const { return *value_; }
  template <typename T>
  [[nodiscard]] bool set_value(const T &value, unsigned = 10) { return *value_ = value, true; }
#endif

 private:
  double *value_;
};
}  // namespace hardware_interface

namespace controller_interface {
enum class CallbackReturn { SUCCESS, FAILURE, ERROR };
enum class return_type { OK, ERROR };
enum class interface_configuration_type { ALL, INDIVIDUAL, NONE };
struct InterfaceConfiguration {
  interface_configuration_type type;
  std::vector<std::string> names;
};

class ControllerInterface {
 public:
  virtual ~ControllerInterface() = default;
  virtual CallbackReturn on_init() = 0;
  virtual InterfaceConfiguration command_interface_configuration() const = 0;
  virtual InterfaceConfiguration state_interface_configuration() const = 0;
  virtual CallbackReturn on_configure(const rclcpp_lifecycle::State &) = 0;
  virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) = 0;
  virtual CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) = 0;
  virtual return_type update(const rclcpp::Time &time, const rclcpp::Duration &period) = 0;
  unsigned get_update_rate() const { return update_rate_; }
  template <typename T>
  T auto_declare(const std::string &, const T &value) { return value; }

  std::vector<hardware_interface::LoanedInterface> command_interfaces_, state_interfaces_;
  unsigned update_rate_ = 1000;
};
}  // namespace controller_interface
