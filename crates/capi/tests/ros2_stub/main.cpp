// Plays the controller manager: configures, activates and updates the example controller on samples from standard
// input, as in examples/rig.c. Prints reference, force and mode of each update.
#include <cstdio>

#include "../../examples/ros2_control/trocar_controller.cpp"

int main(int count, char **arguments)
{
    using controller_interface::CallbackReturn;
    trocar_controller::TrocarController controller;
    if (count < 2 || controller.on_init() != CallbackReturn::SUCCESS) {
        return 2;
    }
    auto &parameters = controller.get_node()->parameters;
    for (auto &parameter : parameters) {
        parameter.second = parameter.first;
    }
    parameters["scenario"] = arguments[1];
    controller.state_interfaces_.resize(controller.state_interface_configuration().names.size());
    controller.command_interfaces_.resize(controller.command_interface_configuration().names.size());
    if (controller.on_configure({}) != CallbackReturn::SUCCESS) {
        return 1;
    }
    double master, slave, velocity, force;
    bool is_active = false;
    while (std::scanf("%lf,%lf,%lf,%lf", &master, &slave, &velocity, &force) == 4) {
        const double values[] = {master, slave, velocity, force};
        for (int at = 0; at < 4; at++) {
            controller.state_interfaces_[at].value = values[at];
        }
        if (!is_active && controller.on_activate({}) != CallbackReturn::SUCCESS) {
            return 1;
        }
        is_active = true;
        if (controller.update({}, {}) != controller_interface::return_type::OK) {
            return 1;
        }
        std::printf("%.17g,%.17g\n", controller.command_interfaces_[0].value, controller.command_interfaces_[1].value);
    }
    return controller.on_deactivate({}) == CallbackReturn::SUCCESS ? 0 : 1;
}
