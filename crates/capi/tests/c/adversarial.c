/* No sequence of samples makes the commands of a rig exceed its settings safety_*. Returns 0 if none of 1,000,000 does. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "trocar.h"

enum { SEQUENCES = 1000000, SEQUENCES_PER_SETTINGS = 25 };

static uint64_t seed = 1;

/* SplitMix64. */
static uint64_t next(void)
{
    uint64_t z = (seed += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

static unsigned below(unsigned end)
{
    return (unsigned)(next() % end);
}

static double share(void)
{
    return (double)(next() >> 11) / 9007199254740992.0;
}

static double magnitude(double low, double high)
{
    return pow(10.0, low + (high - low) * share());
}

/* A reading: plausible, a jump, absurd, or no number. */
static double reading(double near)
{
    switch (below(12)) {
    case 0: return NAN;
    case 1: return INFINITY;
    case 2: return -magnitude(-3.0, 8.0);
    case 3: return magnitude(-12.0, 8.0);
    case 4: return 0.0;
    case 5: return near + magnitude(-3.0, 0.0);
    default: return near + 1e-4 * (share() - 0.5);
    }
}

static double limit(double usual)
{
    return below(3) == 0 ? magnitude(-12.0, 6.0) : usual;
}

static double larger(double a, double b)
{
    return fabs(a) > fabs(b) ? fabs(a) : fabs(b);
}

/* Returns the line of the first condition that does not hold, or 0. */
static int exceeded(const trocar_rig_settings *settings, const trocar_command *before, const trocar_command *now)
{
    double tick_s = settings->simulation_tick_s;
    double rounding = 4.0 * 2.220446049250313e-16;
    double step_n = fabs(now->master_force_n - before->master_force_n);
    double step_m = fabs(now->slave_reference_m - before->slave_reference_m);

    if (!isfinite(now->master_force_n) || !isfinite(now->slave_reference_m)) {
        return __LINE__;
    }
    if (fabs(now->master_force_n) > settings->safety_force_limit_n) {
        return __LINE__;
    }
    if (step_n > settings->safety_force_rate_n_per_s * tick_s +
                     rounding * larger(now->master_force_n, before->master_force_n)) {
        return __LINE__;
    }
    if (step_m > settings->safety_reference_speed_m_per_s * tick_s +
                     rounding * larger(now->slave_reference_m, before->slave_reference_m)) {
        return __LINE__;
    }
    return 0;
}

int main(void)
{
    trocar_rig_settings settings;
    trocar_rig *rig = NULL;
    uint64_t *fresh = NULL;
    size_t words = 0;
    char error[256];
    void *memory = malloc(trocar_rig_size());
    int sequence;

    if (memory == NULL) {
        return 2;
    }
    for (sequence = 0; sequence < SEQUENCES; sequence++) {
        trocar_command before = {0}, command;
        double near = 0.1 * share();
        uint64_t number = 0;
        unsigned ticks = 5 + below(10);
        unsigned tick;
        int has_before = 0;

        if (sequence % SEQUENCES_PER_SETTINGS == 0) {
            static const double TICKS_S[4] = {1e-3, 1e-6, 1.0, 0.02};
            trocar_rig_settings_default(&settings, sizeof settings);
            settings.simulation_tick_s = TICKS_S[below(4)];
            settings.scaling_force = limit(1.0);
            settings.scaling_position = limit(1.0);
            settings.sensor_position_resolution_m = below(2) == 0 ? 0.0 : 1e-6;
            settings.rig_force_limit_n = below(4) == 0 ? 1e6 : 100.0;
            settings.rig_position_limit_m = below(4) == 0 ? 1e6 : 1.0;
            settings.rig_bridged_samples = below(12);
            settings.safety_force_limit_n = limit(20.0);
            settings.safety_force_rate_n_per_s = limit(2000.0);
            settings.safety_reference_speed_m_per_s = limit(0.5);
            settings.safety_lead_m = limit(0.05);
            settings.safety_start_tolerance_m = limit(2e-3);
            settings.safety_alignment_speed_m_per_s = limit(0.03);
            settings.safety_decay_s = limit(0.2);
            settings.safety_bad_samples = 1 + below(12);
            settings.safety_checks_sensors = below(2);
            if (trocar_rig_init(memory, trocar_rig_size(), &settings, &rig, error, sizeof error) != TROCAR_STATUS_OK) {
                fprintf(stderr, "sequence %d: %s\n", sequence, error);
                return 1;
            }
            free(fresh);
            trocar_rig_state_size(rig, &words);
            fresh = malloc(words * sizeof *fresh);
            if (fresh == NULL || trocar_rig_save(rig, fresh, words) != TROCAR_STATUS_OK) {
                return 1;
            }
        } else if (trocar_rig_restore(rig, fresh, words) != TROCAR_STATUS_OK) {
            return 1;
        }
        command.struct_size = sizeof command;
        for (tick = 0; tick < ticks; tick++) {
            trocar_sample sample = {sizeof sample, reading(near), reading(near), reading(0.01), reading(1.0)};
            trocar_status status;
            int line;

            near += 1e-4;
            number += below(4);
            switch (below(40)) {
            case 0: trocar_rig_stop(rig); break;
            case 1: trocar_rig_enable(rig); break;
            case 2: number = next(); break;
            default: break;
            }
            status = below(2) == 0 ? trocar_rig_step(rig, &sample, &command)
                                   : trocar_rig_step_numbered(rig, &sample, number, &command);
            line = status != TROCAR_STATUS_OK ? __LINE__ : has_before ? exceeded(&settings, &before, &command) : 0;
            if (line != 0) {
                fprintf(stderr, "sequence %d, tick %u: line %d\n", sequence, tick, line);
                return 1;
            }
            /* From the first good sample on: before it the position of the slave is not known. */
            if (has_before || command.faults == 0) {
                before = command;
                has_before = 1;
            }
        }
    }
    free(fresh);
    free(memory);
    return 0;
}
