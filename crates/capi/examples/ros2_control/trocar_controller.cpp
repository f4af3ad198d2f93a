// A ros2_control controller that runs trocar's rig. This project does not depend on ROS: it compiles and runs the file
// with a stub of controller_interface in ROS 2 Jazzy (tests/ros2_stub), and has not run it in ROS.
//
// Each tick is one update: the controller reads the sample from the state interfaces of the hardware, and writes the
// command to its command interfaces. The parameters are the names of these interfaces and the path of a scenario. The
// tick of the scenario must be the period of the controller manager.
//
//   trocar_controller:
//     ros__parameters:
//       scenario: /etc/rig/needle.toml
//       master_position: master/position
//       slave_position: slave/position
//       slave_velocity: slave/velocity
//       force: needle_sensor/force.z
//       slave_reference: slave/position
//       master_force: master/effort
//
// The limits of the commands are the keys safety. of the scenario. After bad samples the force decays and the reference
// holds; a fault of a sensor ends with a deactivation and an activation.
#include <cstddef>
#include <fstream>
#include <iterator>
#include <new>
#include <string>
#include <vector>

#include "controller_interface/controller_interface.hpp"
#include "pluginlib/class_list_macros.hpp"
#include "trocar.h"

namespace trocar_controller {

using controller_interface::CallbackReturn;
using controller_interface::InterfaceConfiguration;
using controller_interface::interface_configuration_type;
using controller_interface::return_type;

class TrocarController : public controller_interface::ControllerInterface {
public:
    CallbackReturn on_init() override
    {
        for (const char *name : {"scenario", "master_position", "slave_position", "slave_velocity", "force",
                                 "slave_reference", "master_force"}) {
            auto_declare<std::string>(name, "");
        }
        return CallbackReturn::SUCCESS;
    }

    InterfaceConfiguration state_interface_configuration() const override
    {
        return {interface_configuration_type::INDIVIDUAL,
                {text("master_position"), text("slave_position"), text("slave_velocity"), text("force")}};
    }

    InterfaceConfiguration command_interface_configuration() const override
    {
        return {interface_configuration_type::INDIVIDUAL, {text("slave_reference"), text("master_force")}};
    }

    // Reads the scenario and allocates the memory of the rig. Not real-time safe.
    CallbackReturn on_configure(const rclcpp_lifecycle::State &) override
    {
        std::ifstream file(text("scenario"));
        const std::string scenario{std::istreambuf_iterator<char>(file), {}};
        char error[1024] = "";
        trocar_status status = trocar_rig_settings_from_toml(scenario.data(), scenario.size(), &settings_,
                                                             sizeof settings_, error, sizeof error);
        if (status != TROCAR_STATUS_OK) {
            RCLCPP_ERROR(get_node()->get_logger(), "%s", *error != '\0' ? error : trocar_status_text(status));
            return CallbackReturn::ERROR;
        }
        memory_.resize(trocar_rig_size() / sizeof(std::max_align_t) + 1);
        return CallbackReturn::SUCCESS;
    }

    // Starts the rig at the position of the master, so that the reference does not jump.
    CallbackReturn on_activate(const rclcpp_lifecycle::State &) override
    {
        settings_.rig_start_m = state_interfaces_[0].get_value();
        char error[1024] = "";
        const trocar_status status = trocar_rig_init(memory_.data(), memory_.size() * sizeof(std::max_align_t), &settings_,
                                                     &rig_, error, sizeof error);
        if (status != TROCAR_STATUS_OK) {
            RCLCPP_ERROR(get_node()->get_logger(), "%s", *error != '\0' ? error : trocar_status_text(status));
            return CallbackReturn::ERROR;
        }
        return CallbackReturn::SUCCESS;
    }

    CallbackReturn on_deactivate(const rclcpp_lifecycle::State &) override
    {
        trocar_rig_stop(rig_);
        return CallbackReturn::SUCCESS;
    }

    return_type update(const rclcpp::Time &, const rclcpp::Duration &) override
    {
        const trocar_sample sample{sizeof(trocar_sample), state_interfaces_[0].get_value(),
                                   state_interfaces_[1].get_value(), state_interfaces_[2].get_value(),
                                   state_interfaces_[3].get_value()};
        if (trocar_rig_step(rig_, &sample, &command_) != TROCAR_STATUS_OK) {
            return return_type::ERROR;
        }
        command_interfaces_[0].set_value(command_.slave_reference_m);
        // The feedback force pushes the master against the direction of insertion.
        command_interfaces_[1].set_value(-command_.master_force_n);
        return return_type::OK;
    }

private:
    std::string text(const char *name) const { return get_node()->get_parameter(name).as_string(); }

    trocar_rig_settings settings_{};
    std::vector<std::max_align_t> memory_;
    trocar_rig *rig_ = nullptr;
    trocar_command command_{sizeof(trocar_command), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
};

} // namespace trocar_controller

PLUGINLIB_EXPORT_CLASS(trocar_controller::TrocarController, controller_interface::ControllerInterface)
