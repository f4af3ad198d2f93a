/* Checks the interface besides commands: sizes, rejections, texts. Prints nothing and returns 0 on success. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "trocar.h"

#define CHECK(holds)                                                             \
    do {                                                                         \
        if (!(holds)) {                                                          \
            fprintf(stderr, "line %d does not hold: %s\n", __LINE__, #holds);    \
            return 1;                                                            \
        }                                                                        \
    } while (0)

int main(void)
{
    const char *scenario = "base = \"builtin:paper/augmented\"\n[estimator]\ncontact_m = 0.02\n";
    const char *wrong = "[estimator]\ncontact = 0.02\n";
    size_t size = trocar_rig_size();
    trocar_rig_settings settings;
    trocar_sample sample = {sizeof sample, NAN, NAN, NAN, NAN};
    trocar_command command;
    trocar_rig *rig = NULL;
    char error[64];
    /* Eight additional bytes for a test of misaligned memory. */
    char *memory = malloc(size + 8);

    CHECK(memory != NULL);
    CHECK(strcmp(trocar_version(), TROCAR_TEST_VERSION) == 0);
    CHECK(trocar_rig_alignment() == 8);
    CHECK(strcmp(trocar_status_text(TROCAR_STATUS_OK), "done") == 0);
    CHECK(strcmp(trocar_status_text(-7), "unknown status") == 0);

    /* Rejections: null, a wrong size, too little memory, a misaligned address. */
    CHECK(trocar_rig_settings_default(NULL, sizeof settings) == TROCAR_STATUS_NULL);
    CHECK(trocar_rig_settings_default(&settings, sizeof settings - 8) == TROCAR_STATUS_STRUCT_SIZE);
    CHECK(trocar_rig_settings_default(&settings, sizeof settings) == TROCAR_STATUS_OK);
    CHECK(settings.struct_size == sizeof settings);
    CHECK(trocar_rig_init(NULL, size, &settings, &rig, error, sizeof error) == TROCAR_STATUS_NULL);
    CHECK(trocar_rig_init(memory, size, NULL, &rig, error, sizeof error) == TROCAR_STATUS_NULL);
    CHECK(trocar_rig_init(memory, size, &settings, NULL, error, sizeof error) == TROCAR_STATUS_NULL);
    CHECK(trocar_rig_init(memory, size - 1, &settings, &rig, error, sizeof error) == TROCAR_STATUS_MEMORY_SIZE);
    CHECK(trocar_rig_init(memory + 1, size, &settings, &rig, error, sizeof error) == TROCAR_STATUS_ALIGNMENT);
    settings.struct_size -= 8;
    CHECK(trocar_rig_init(memory, size, &settings, &rig, error, sizeof error) == TROCAR_STATUS_STRUCT_SIZE);
    settings.struct_size += 8;

    /* A setting out of range, and an unknown word, are reported with their keys. */
    settings.detector_quiet_std_n = -1.0;
    CHECK(trocar_rig_init(memory, size, &settings, &rig, error, sizeof error) == TROCAR_STATUS_SETTING);
    CHECK(strncmp(error, "detector.quiet_std_n is -1, must be", 35) == 0);
    /* Without a buffer, and with a buffer of one byte. */
    CHECK(trocar_rig_init(memory, size, &settings, &rig, NULL, 0) == TROCAR_STATUS_SETTING);
    CHECK(trocar_rig_init(memory, size, &settings, &rig, error, 1) == TROCAR_STATUS_SETTING && error[0] == '\0');
    settings.detector_quiet_std_n = 0.02;
    settings.detector_motion = 3;
    CHECK(trocar_rig_init(memory, size, &settings, &rig, error, sizeof error) == TROCAR_STATUS_SETTING);
    CHECK(strncmp(error, "detector.motion must be one of", 30) == 0 && rig == NULL);
    settings.detector_motion = TROCAR_DETECTOR_MOTION_INSERTING;

    /* A step before the rig is initialised, and with wrong sizes. */
    memset(memory, 0, size);
    command.struct_size = sizeof command;
    CHECK(trocar_rig_step((trocar_rig *)memory, &sample, &command) == TROCAR_STATUS_NOT_INITIALISED);
    CHECK(trocar_rig_init(memory, size, &settings, &rig, error, sizeof error) == TROCAR_STATUS_OK);
    CHECK((void *)rig == (void *)memory);
    CHECK(trocar_rig_step(NULL, &sample, &command) == TROCAR_STATUS_NULL);
    CHECK(trocar_rig_step(rig, NULL, &command) == TROCAR_STATUS_NULL);
    CHECK(trocar_rig_step(rig, &sample, NULL) == TROCAR_STATUS_NULL);
    sample.struct_size = 8;
    CHECK(trocar_rig_step(rig, &sample, &command) == TROCAR_STATUS_STRUCT_SIZE);
    sample.struct_size = sizeof sample;
    command.struct_size = 8;
    CHECK(trocar_rig_step(rig, &sample, &command) == TROCAR_STATUS_STRUCT_SIZE);

    /* A tick without a sample: every channel is faulty, but the commands are valid numbers. */
    command.struct_size = sizeof command;
    CHECK(trocar_rig_step(rig, &sample, &command) == TROCAR_STATUS_OK);
    CHECK(command.faults == 15 && command.faulty_samples == 1 && command.alarm == 0);
    CHECK(command.slave_reference_m == 0.0 && command.master_force_n == 0.0);

    /* A scenario. */
    CHECK(trocar_rig_init_toml(memory, size, scenario, strlen(scenario), &rig, error, sizeof error) == TROCAR_STATUS_OK);
    CHECK(trocar_rig_settings_from_toml(scenario, strlen(scenario), &settings, sizeof settings, error, sizeof error) ==
          TROCAR_STATUS_OK);
    CHECK(settings.estimator_contact_m == 0.02 && settings.augmentation_enabled == 1);
    CHECK(trocar_rig_init_toml(memory, size, wrong, strlen(wrong), &rig, error, sizeof error) == TROCAR_STATUS_SCENARIO);
    CHECK(strstr(error, "scenario:2") != NULL);
    CHECK(trocar_rig_init_toml(memory, size, NULL, 0, &rig, error, sizeof error) == TROCAR_STATUS_NULL);
    CHECK(trocar_rig_init_toml(memory, size, "\xff", 1, &rig, error, sizeof error) == TROCAR_STATUS_SCENARIO);
    free(memory);
    return 0;
}
