// The same as rig.c in C++: a class owns the memory of the rig.
//
//     rig_cpp [SCENARIO] < samples.csv > alarms.csv
//
// Prints a line for each alarm: the number of the sample, the reference (m) and the force (N).
#include <cstddef>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <new>
#include <stdexcept>
#include <string>

#include "trocar.h"

namespace {

// The settings of a rig: the defaults, or those of a scenario.
trocar_rig_settings settings_of(const char *path)
{
    trocar_rig_settings settings;
    trocar_status status = trocar_rig_settings_default(&settings, sizeof settings);
    if (path != nullptr) {
        std::ifstream file(path);
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        char error[1024] = "";
        status = trocar_rig_settings_from_toml(text.data(), text.size(), &settings, sizeof settings, error, sizeof error);
        if (status == TROCAR_STATUS_SCENARIO) {
            throw std::runtime_error(error);
        }
    }
    if (status != TROCAR_STATUS_OK) {
        throw std::runtime_error(trocar_status_text(status));
    }
    return settings;
}

// A rig and the memory that it uses. `step` is safe in a real-time thread: it allocates nothing and does not block.
class Rig {
public:
    explicit Rig(const trocar_rig_settings &settings)
        : memory_(::operator new(trocar_rig_size()))
    {
        char error[1024] = "";
        const trocar_status status =
            trocar_rig_init(memory_, trocar_rig_size(), &settings, &rig_, error, sizeof error);
        if (status != TROCAR_STATUS_OK) {
            ::operator delete(memory_);
            throw std::runtime_error(*error != '\0' ? error : trocar_status_text(status));
        }
    }
    ~Rig() { ::operator delete(memory_); }
    Rig(const Rig &) = delete;
    Rig &operator=(const Rig &) = delete;

    const trocar_command &step(double master_m, double slave_m, double slave_m_per_s, double force_n) noexcept
    {
        const trocar_sample sample{sizeof(trocar_sample), master_m, slave_m, slave_m_per_s, force_n};
        trocar_rig_step(rig_, &sample, &command_);
        return command_;
    }

private:
    void *memory_;
    trocar_rig *rig_ = nullptr;
    trocar_command command_{sizeof(trocar_command), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
};

} // namespace

int main(int count, char **arguments)
try {
    Rig rig(settings_of(count > 1 ? arguments[1] : nullptr));
    double master, slave, velocity, force;
    for (long k = 0; std::scanf("%lf,%lf,%lf,%lf", &master, &slave, &velocity, &force) == 4; ++k) {
        const trocar_command &command = rig.step(master, slave, velocity, force);
        if (command.alarm) {
            std::printf("%ld,%.17g,%.17g\n", k, command.slave_reference_m, command.master_force_n);
        }
    }
    return 0;
} catch (const std::exception &error) {
    std::cerr << "rig: " << error.what() << "\n";
    return 2;
}
