// A stub of the parts of ROS 2 Jazzy that the example uses, with the signatures of ros2_control, so that the example
// compiles and runs here. It is not ROS: it has no executor, no real parameters and no real hardware.
#pragma once
#include <cstdarg>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace rclcpp {

struct Logger {};
class Time {};
class Duration {};

class Parameter {
public:
    explicit Parameter(std::string value = "") : value_(std::move(value)) {}
    std::string as_string() const { return value_; }
    long as_int() const { return std::stol(value_); }

private:
    std::string value_;
};

} // namespace rclcpp

namespace rclcpp_lifecycle {

class State {};

class LifecycleNode {
public:
    rclcpp::Logger get_logger() const { return {}; }
    rclcpp::Parameter get_parameter(const std::string &name) const { return rclcpp::Parameter(parameters.at(name)); }

    std::map<std::string, std::string> parameters;
};

} // namespace rclcpp_lifecycle

inline void stub_log(const rclcpp::Logger &, const char *format, ...)
{
    std::va_list values;
    va_start(values, format);
    std::vfprintf(stderr, format, values);
    va_end(values);
    std::fputc('\n', stderr);
}
#define RCLCPP_ERROR(...) stub_log(__VA_ARGS__)
#define RCLCPP_WARN(...) stub_log(__VA_ARGS__)

namespace hardware_interface {

class LoanedStateInterface {
public:
    double get_value() const { return value; }

    double value = 0.0;
};

class LoanedCommandInterface {
public:
    void set_value(double given) { value = given; }

    double value = 0.0;
};

} // namespace hardware_interface

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
    virtual CallbackReturn on_configure(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_activate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
    virtual CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) { return CallbackReturn::SUCCESS; }
    virtual return_type update(const rclcpp::Time &, const rclcpp::Duration &) = 0;

    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> get_node() const { return node_; }

    // The test plays the controller manager and the hardware.
    std::vector<hardware_interface::LoanedStateInterface> state_interfaces_;
    std::vector<hardware_interface::LoanedCommandInterface> command_interfaces_;

protected:
    template <typename Value> void auto_declare(const std::string &name, const Value &) { node_->parameters[name]; }

private:
    std::shared_ptr<rclcpp_lifecycle::LifecycleNode> node_ = std::make_shared<rclcpp_lifecycle::LifecycleNode>();
};

} // namespace controller_interface
