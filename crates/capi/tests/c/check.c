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
    trocar_counts counts;
    trocar_rig *rig = NULL;
    trocar_detector *detector = NULL;
    trocar_detector_sample needle = {sizeof needle, NAN, NAN, NAN};
    trocar_detection detection;
    trocar_rig *const invalid = (trocar_rig *)(uintptr_t)0xdead;
    uint64_t *state;
    size_t words = 0;
    double force_n;
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

    /* Every failed call leaves null, whatever was in the pointer. */
    rig = invalid;
    CHECK(trocar_rig_init(memory, size, NULL, &rig, error, sizeof error) == TROCAR_STATUS_NULL && rig == NULL);
    rig = invalid;
    CHECK(trocar_rig_init(NULL, size, &settings, &rig, error, sizeof error) == TROCAR_STATUS_NULL && rig == NULL);
    rig = invalid;
    CHECK(trocar_rig_init(memory, size - 1, &settings, &rig, error, sizeof error) == TROCAR_STATUS_MEMORY_SIZE && rig == NULL);
    rig = invalid;
    settings.struct_size -= 8;
    CHECK(trocar_rig_init(memory, size, &settings, &rig, error, sizeof error) == TROCAR_STATUS_STRUCT_SIZE && rig == NULL);
    CHECK(strncmp(error, "struct_size of the settings is", 30) == 0);
    settings.struct_size += 8;
    rig = invalid;
    CHECK(trocar_rig_init_toml(memory, size, wrong, strlen(wrong), &rig, error, sizeof error) == TROCAR_STATUS_SCENARIO);
    CHECK(rig == NULL);
    rig = invalid;
    CHECK(trocar_rig_init_toml(memory, size, NULL, 0, &rig, error, sizeof error) == TROCAR_STATUS_NULL && rig == NULL);

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

    CHECK(command.detection == 1 && command.state == 1 && command.fault == 0 && command.limited == 0);

    /* A repeated sample counts as missing; stop and enable change the state. */
    sample.master_position_m = sample.slave_position_m = 0.0;
    sample.slave_velocity_m_per_s = 0.0;
    sample.force_n = 1.0;
    CHECK(trocar_rig_step_numbered(rig, &sample, 2, &command) == TROCAR_STATUS_OK && command.faults == 0);
    CHECK(command.state == 2 && command.master_force_n > 0.0);
    CHECK(trocar_rig_step_numbered(rig, &sample, 2, &command) == TROCAR_STATUS_OK && command.faults == 15);
    counts.struct_size = 8;
    CHECK(trocar_rig_counts(rig, &counts) == TROCAR_STATUS_STRUCT_SIZE);
    counts.struct_size = sizeof counts;
    CHECK(trocar_rig_counts(rig, NULL) == TROCAR_STATUS_NULL && trocar_rig_counts(NULL, &counts) == TROCAR_STATUS_NULL);
    CHECK(trocar_rig_counts(rig, &counts) == TROCAR_STATUS_OK && counts.repeated == 1 && counts.bad == 2);
    CHECK(trocar_rig_stop(NULL) == TROCAR_STATUS_NULL && trocar_rig_stop(rig) == TROCAR_STATUS_OK);
    CHECK(trocar_rig_step_numbered(rig, &sample, 3, &command) == TROCAR_STATUS_OK && command.state == 0);

    /* A rig continues from its saved state; a damaged state is rejected. */
    CHECK(trocar_rig_state_size(rig, &words) == TROCAR_STATUS_OK && words > 10);
    state = malloc(words * sizeof *state);
    CHECK(state != NULL && trocar_rig_save(rig, state, words) == TROCAR_STATUS_OK);
    CHECK(trocar_rig_save(rig, state, words - 1) == TROCAR_STATUS_STATE);
    CHECK(trocar_rig_enable(rig) == TROCAR_STATUS_OK);
    CHECK(trocar_rig_step_numbered(rig, &sample, 4, &command) == TROCAR_STATUS_OK && command.state == 2);
    force_n = command.master_force_n;
    CHECK(trocar_rig_restore(rig, state, words) == TROCAR_STATUS_OK);
    CHECK(trocar_rig_enable(rig) == TROCAR_STATUS_OK);
    CHECK(trocar_rig_step_numbered(rig, &sample, 4, &command) == TROCAR_STATUS_OK);
    CHECK(command.state == 2 && command.master_force_n == force_n);
    state[words / 2] ^= 1;
    CHECK(trocar_rig_restore(rig, state, words) == TROCAR_STATUS_STATE);
    state[words / 2] ^= 1;
    settings.estimator_contact_m = 0.001;
    CHECK(trocar_rig_init(memory, size, &settings, &rig, error, sizeof error) == TROCAR_STATUS_OK);
    CHECK(trocar_rig_restore(rig, state, words) == TROCAR_STATUS_STATE);
    free(state);

    /* A scenario. */
    CHECK(trocar_rig_init_toml(memory, size, scenario, strlen(scenario), &rig, error, sizeof error) == TROCAR_STATUS_OK);
    CHECK(trocar_rig_settings_from_toml(scenario, strlen(scenario), &settings, sizeof settings, error, sizeof error) ==
          TROCAR_STATUS_OK);
    CHECK(settings.estimator_contact_m == 0.02 && settings.augmentation_enabled == 1);
    CHECK(trocar_rig_init_toml(memory, size, wrong, strlen(wrong), &rig, error, sizeof error) == TROCAR_STATUS_SCENARIO);
    CHECK(strstr(error, "scenario:2") != NULL);
    CHECK(trocar_rig_init_toml(memory, size, NULL, 0, &rig, error, sizeof error) == TROCAR_STATUS_NULL);
    CHECK(trocar_rig_init_toml(memory, size, "\xff", 1, &rig, error, sizeof error) == TROCAR_STATUS_SCENARIO);

    /* The detector alone: the same rejections, and the same text. */
    CHECK(trocar_detector_size() < size && trocar_detector_alignment() == 8);
    CHECK(trocar_rig_settings_default(&settings, sizeof settings) == TROCAR_STATUS_OK);
    detector = (trocar_detector *)invalid;
    CHECK(trocar_detector_init(memory, trocar_detector_size() - 1, &settings, &detector, error, sizeof error) ==
          TROCAR_STATUS_MEMORY_SIZE && detector == NULL);
    CHECK(trocar_detector_init(memory + 1, size, &settings, &detector, error, sizeof error) == TROCAR_STATUS_ALIGNMENT);
    CHECK(trocar_detector_init(memory, size, NULL, &detector, error, sizeof error) == TROCAR_STATUS_NULL);
    settings.detector_quiet_std_n = -1.0;
    CHECK(trocar_detector_init(memory, size, &settings, &detector, error, sizeof error) == TROCAR_STATUS_SETTING);
    CHECK(strncmp(error, "detector.quiet_std_n is -1, must be", 35) == 0 && detector == NULL);
    settings.detector_quiet_std_n = 0.02;
    memset(memory, 0, size);
    detection.struct_size = sizeof detection;
    CHECK(trocar_detector_step((trocar_detector *)memory, &needle, &detection) == TROCAR_STATUS_NOT_INITIALISED);
    CHECK(trocar_detector_init(memory, size, &settings, &detector, error, sizeof error) == TROCAR_STATUS_OK);
    /* A detector is no rig. */
    CHECK(trocar_rig_stop((trocar_rig *)memory) == TROCAR_STATUS_NOT_INITIALISED);
    CHECK(trocar_detector_step(NULL, &needle, &detection) == TROCAR_STATUS_NULL);
    CHECK(trocar_detector_step(detector, NULL, &detection) == TROCAR_STATUS_NULL);
    CHECK(trocar_detector_step(detector, &needle, NULL) == TROCAR_STATUS_NULL);
    needle.struct_size = 8;
    CHECK(trocar_detector_step(detector, &needle, &detection) == TROCAR_STATUS_STRUCT_SIZE);
    needle.struct_size = sizeof needle;
    CHECK(trocar_detector_step(detector, &needle, &detection) == TROCAR_STATUS_OK);
    CHECK(detection.faults == 14 && detection.faulty_samples == 1 && detection.alarm == 0 && detection.state == 1);
    needle.position_m = needle.velocity_m_per_s = needle.force_n = 0.0;
    CHECK(trocar_detector_step_numbered(detector, &needle, 2, &detection) == TROCAR_STATUS_OK && detection.faults == 0);
    CHECK(trocar_detector_step_numbered(detector, &needle, 2, &detection) == TROCAR_STATUS_OK && detection.faults == 14);
    scenario = "detector.threshold = 0.05\n[safety]\nforce_limit_n = 8.0\n";
    CHECK(trocar_detector_init_toml(memory, size, scenario, strlen(scenario), &detector, error, sizeof error) ==
          TROCAR_STATUS_OK);
    detector = (trocar_detector *)invalid;
    CHECK(trocar_detector_init_toml(memory, size, wrong, strlen(wrong), &detector, error, sizeof error) ==
          TROCAR_STATUS_SCENARIO && detector == NULL);
    free(memory);
    return 0;
}
