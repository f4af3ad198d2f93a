/*
 * Runs the controller of a rig on samples, one per line, like the timer thread of a rig at each tick.
 *
 *     rig [--toml SCENARIO] [--tick S] [--contact M] < samples.csv > commands.csv
 *
 * A line of samples: master position (m), slave position (m), slave velocity (m/s), force (N), separated by commas.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "trocar.h"

/* Reports an error and returns the status of invalid input. */
static int refuse(const char *what, const char *why)
{
    fprintf(stderr, "rig: %s: %s\n", what, why);
    return 2;
}

/* Reads a scenario into the settings. */
static int read_scenario(const char *path, trocar_rig_settings *settings)
{
    static char text[1 << 20];
    char error[1024];
    trocar_status status;
    size_t size;
    FILE *file = fopen(path, "rb");

    if (file == NULL) {
        return refuse(path, "cannot be opened");
    }
    size = fread(text, 1, sizeof text, file);
    fclose(file);
    status = trocar_rig_settings_from_toml(text, size, settings, sizeof *settings, error, sizeof error);
    if (status != TROCAR_STATUS_OK) {
        return refuse(path, status == TROCAR_STATUS_SCENARIO ? error : trocar_status_text(status));
    }
    return 0;
}

int main(int count, char **arguments)
{
    trocar_rig_settings settings;
    trocar_rig *rig;
    trocar_sample sample = {sizeof sample, 0.0, 0.0, 0.0, 0.0};
    trocar_command command = {sizeof command, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};
    trocar_status status;
    char error[1024];
    char line[256];
    void *memory;
    int at;

    trocar_rig_settings_default(&settings, sizeof settings);
    for (at = 1; at + 1 < count; at += 2) {
        if (strcmp(arguments[at], "--toml") == 0) {
            int failed = read_scenario(arguments[at + 1], &settings);
            if (failed) {
                return failed;
            }
        } else if (strcmp(arguments[at], "--tick") == 0) {
            settings.simulation_tick_s = strtod(arguments[at + 1], NULL);
        } else if (strcmp(arguments[at], "--contact") == 0) {
            settings.estimator_contact_m = strtod(arguments[at + 1], NULL);
        } else {
            break;
        }
    }
    if (at < count) {
        return refuse(arguments[at], "there are --toml FILE, --tick S, --contact M");
    }

    /* The program owns all memory; malloc aligns it. */
    memory = malloc(trocar_rig_size());
    if (memory == NULL) {
        return refuse("memory", "there is none");
    }
    status = trocar_rig_init(memory, trocar_rig_size(), &settings, &rig, error, sizeof error);
    if (status != TROCAR_STATUS_OK) {
        free(memory);
        return refuse("settings", status == TROCAR_STATUS_SETTING ? error : trocar_status_text(status));
    }

    puts("slave_reference_m,master_force_n,allowed_force_step_n,stiffness_n_per_m,damping_n_s_per_m,predicted_force_n,"
         "residual_n,distance,decision,slave_velocity_m_per_s,mode,alarm,alarm_taken,faults,faulty_samples,"
         "detection,state,limited");
    while (fgets(line, sizeof line, stdin) != NULL) {
        char *rest = line;
        sample.master_position_m = strtod(rest, &rest);
        sample.slave_position_m = strtod(rest + (*rest == ','), &rest);
        sample.slave_velocity_m_per_s = strtod(rest + (*rest == ','), &rest);
        sample.force_n = strtod(rest + (*rest == ','), &rest);
        status = trocar_rig_step(rig, &sample, &command);
        if (status != TROCAR_STATUS_OK) {
            fprintf(stderr, "rig: %s\n", trocar_status_text(status));
            free(memory);
            return 1;
        }
        printf("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%u,%u,%u,%u,%u,%u,%u,%u\n",
               command.slave_reference_m, command.master_force_n, command.allowed_force_step_n,
               command.stiffness_n_per_m, command.damping_n_s_per_m, command.predicted_force_n, command.residual_n,
               command.distance, command.decision, command.slave_velocity_m_per_s, (unsigned)command.mode,
               (unsigned)command.alarm, (unsigned)command.alarm_taken, (unsigned)command.faults,
               (unsigned)command.faulty_samples, (unsigned)command.detection, (unsigned)command.state,
               (unsigned)command.limited);
    }
    free(memory);
    return 0;
}
