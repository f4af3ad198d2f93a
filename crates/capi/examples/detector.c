/*
 * Runs the detector alone on samples, one per line, and prints its results: for a rig whose controller is not trocar.
 *
 *     detector [--toml SCENARIO] [--tick S] [--contact M] < samples.csv > detections.csv
 *
 * A line of samples: position (m), velocity (m/s), force (N), separated by commas.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "trocar.h"

/* Reports an error and returns the status of invalid input. */
static int refuse(const char *what, const char *why)
{
    fprintf(stderr, "detector: %s: %s\n", what, why);
    return 2;
}

/* Reads a scenario into the settings. It needs only the keys of the controller and safety. */
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
    trocar_detector *detector;
    trocar_detector_sample sample = {sizeof sample, 0.0, 0.0, 0.0};
    trocar_detection detection;
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

    memory = malloc(trocar_detector_size());
    if (memory == NULL) {
        return refuse("memory", "there is none");
    }
    status = trocar_detector_init(memory, trocar_detector_size(), &settings, &detector, error, sizeof error);
    if (status != TROCAR_STATUS_OK) {
        free(memory);
        return refuse("settings", status == TROCAR_STATUS_SETTING ? error : trocar_status_text(status));
    }

    puts("stiffness_n_per_m,damping_n_s_per_m,predicted_force_n,residual_n,distance,decision,velocity_m_per_s,alarm,state");
    detection.struct_size = sizeof detection;
    while (fgets(line, sizeof line, stdin) != NULL) {
        char *rest = line;
        sample.position_m = strtod(rest, &rest);
        sample.velocity_m_per_s = strtod(rest + (*rest == ','), &rest);
        sample.force_n = strtod(rest + (*rest == ','), &rest);
        status = trocar_detector_step(detector, &sample, &detection);
        if (status != TROCAR_STATUS_OK) {
            fprintf(stderr, "detector: %s\n", trocar_status_text(status));
            free(memory);
            return 1;
        }
        printf("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%u,%u\n", detection.stiffness_n_per_m,
               detection.damping_n_s_per_m, detection.predicted_force_n, detection.residual_n, detection.distance,
               detection.decision, detection.velocity_m_per_s, (unsigned)detection.alarm, (unsigned)detection.state);
    }
    free(memory);
    return 0;
}
