/* A tissue as a unit for co-simulation, written without trocar: a spring and a damper that give way at a depth.
 *
 * FMI is 2 or 3. FAULT makes it fail from 0.05 s on: 1 an error, 2 a force that is not a number, 3 a fatal error, 4 the wish to end
 * the simulation (3.0 only); or at its start: 5 no instance at all, 6 a refused parameter. STATE follows the position with a time
 * constant of 10 ms, in own steps of 0.1 ms, and is the force on the shaft.
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#ifndef FAULT
#define FAULT 0
#endif

enum { POSITION = 1, VELOCITY, FORCE, RUPTURED, STIFFNESS, DAMPING, CONTACT, DEPTH, LAYERS, STATE, UNUSED, COUNT };

typedef struct {
  double value[COUNT];
  int32_t layers;
  const void *logger, *environment;
  void (*release)(void *);
} Tissue;

static void report(Tissue *tissue, int status, const char *text);

static Tissue *start(void *memory, const void *logger, const void *environment, void (*release)(void *)) {
  Tissue *tissue = memory;
  if (tissue == NULL || FAULT == 5) {
    return NULL;
  }
  *tissue = (Tissue){.logger = logger, .environment = environment, .release = release, .layers = 1};
  tissue->value[STIFFNESS] = 200.0;
  tissue->value[DAMPING] = 5.0;
  tissue->value[DEPTH] = 1.0;
  return tissue;
}

static int step(Tissue *tissue, double time, double length) {
  double *v = tissue->value;
  double depth = v[POSITION] - v[CONTACT];
  v[FORCE] = depth > 0.0 ? v[STIFFNESS] * depth + v[DAMPING] * v[VELOCITY] : 0.0;
  v[RUPTURED] = tissue->layers > 0 && depth > v[DEPTH];
  for (int k = 0; k < (int)(length / 1e-4 + 0.5); k++) {
    v[STATE] += 1e-4 * (v[POSITION] - v[STATE]) / 0.01;
  }
  if (FAULT == 2 && time >= 0.05) {
    v[FORCE] = NAN;
  }
  if ((FAULT == 1 || FAULT == 3) && time >= 0.05) {
    report(tissue, FAULT == 1 ? 3 : 4, "the mesh is inverted at element 17\n\x1b[31m");
    return FAULT == 1 ? 3 : 4;
  }
  return 0;
}

static int set(Tissue *tissue, const uint32_t *reference, size_t count, const double *value) {
  for (size_t k = 0; k < count; k++) {
    if (FAULT == 6 && reference[k] == STIFFNESS) {
      report(tissue, 3, "the stiffness is frozen");
      return 3;
    }
    tissue->value[reference[k]] = value[k];
  }
  return 0;
}

static int get(Tissue *tissue, const uint32_t *reference, size_t count, double *value) {
  for (size_t k = 0; k < count; k++) {
    value[k] = tissue->value[reference[k]];
  }
  return 0;
}

static int none(void) { return 0; }

#if FMI == 2
typedef struct {
  void (*logger)(const void *, const char *, int, const char *, const char *, ...);
  void *(*allocate)(size_t, size_t);
  void (*release)(void *);
  const void *finished, *environment;
} Callbacks;

static void report(Tissue *tissue, int status, const char *text) {
  void (*logger)(const void *, const char *, int, const char *, const char *, ...) = tissue->logger;
  logger(tissue->environment, "one", status, "logStatusError", text);
}

void *fmi2Instantiate(const char *name, int kind, const char *guid, const char *resources, const Callbacks *callbacks, int visible,
                      int logging) {
  (void)name, (void)guid, (void)resources, (void)visible, (void)logging;
  void *memory = kind == 1 ? callbacks->allocate(1, sizeof(Tissue)) : NULL;
  return start(memory, callbacks->logger, callbacks->environment, callbacks->release);
}
void fmi2FreeInstance(Tissue *tissue) { tissue->release(tissue); }
int fmi2SetupExperiment(void *t, int a, double b, double c, int d, double e) { (void)t, (void)a, (void)b, (void)c, (void)d, (void)e; return 0; }
int fmi2EnterInitializationMode(void *t) { (void)t; return none(); }
int fmi2ExitInitializationMode(void *t) { (void)t; return none(); }
int fmi2Terminate(void *t) { (void)t; return none(); }
int fmi2DoStep(Tissue *t, double time, double length, int final) { (void)final; return step(t, time, length); }
int fmi2SetReal(Tissue *t, const uint32_t *r, size_t n, const double *v) { return set(t, r, n, v); }
int fmi2GetReal(Tissue *t, const uint32_t *r, size_t n, double *v) { return get(t, r, n, v); }
int fmi2SetInteger(Tissue *t, const uint32_t *r, size_t n, const int *v) { (void)r, (void)n; t->layers = v[0]; return 0; }
int fmi2GetInteger(Tissue *t, const uint32_t *r, size_t n, int *v) { (void)r, (void)n; v[0] = t->layers; return 0; }
int fmi2SetBoolean(Tissue *t, const uint32_t *r, size_t n, const int *v) { (void)t, (void)r, (void)n, (void)v; return 3; }
int fmi2GetBoolean(Tissue *t, const uint32_t *r, size_t n, int *v) { (void)r, (void)n; v[0] = t->value[RUPTURED] != 0.0; return 0; }
#else
typedef void Logger(const void *, int, const char *, const char *);

static void report(Tissue *tissue, int status, const char *text) {
  Logger *logger = tissue->logger;
  logger(tissue->environment, status, "error", text);
}

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging, bool events,
                                  bool early, const uint32_t *required, size_t count, const void *environment, const Logger *logger,
                                  const void *update) {
  (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
  (void)required, (void)count, (void)update;
  return start(malloc(sizeof(Tissue)), logger, environment, free);
}
void fmi3FreeInstance(Tissue *tissue) { tissue->release(tissue); }
int fmi3EnterInitializationMode(void *t, bool a, double b, double c, bool d, double e) { (void)t, (void)a, (void)b, (void)c, (void)d, (void)e; return 0; }
int fmi3ExitInitializationMode(void *t) { (void)t; return none(); }
int fmi3Terminate(void *t) { (void)t; return none(); }
int fmi3DoStep(Tissue *t, double time, double length, bool final, bool *event, bool *end, bool *early, double *last) {
  (void)final;
  *event = *early = false;
  *end = FAULT == 4 && time >= 0.05;
  *last = time + length;
  return step(t, time, length);
}
int fmi3SetFloat64(Tissue *t, const uint32_t *r, size_t n, const double *v, size_t m) { (void)m; return set(t, r, n, v); }
int fmi3GetFloat64(Tissue *t, const uint32_t *r, size_t n, double *v, size_t m) { (void)m; return get(t, r, n, v); }
int fmi3SetInt32(Tissue *t, const uint32_t *r, size_t n, const int32_t *v, size_t m) { (void)r, (void)n, (void)m; t->layers = v[0]; return 0; }
int fmi3GetInt32(Tissue *t, const uint32_t *r, size_t n, int32_t *v, size_t m) { (void)r, (void)n, (void)m; v[0] = t->layers; return 0; }
int fmi3SetInt64(Tissue *t, const uint32_t *r, size_t n, const int64_t *v, size_t m) { (void)t, (void)r, (void)n, (void)v, (void)m; return 3; }
int fmi3GetInt64(Tissue *t, const uint32_t *r, size_t n, int64_t *v, size_t m) { (void)t, (void)r, (void)n, (void)v, (void)m; return 3; }
int fmi3SetBoolean(Tissue *t, const uint32_t *r, size_t n, const bool *v, size_t m) { (void)t, (void)r, (void)n, (void)v, (void)m; return 3; }
int fmi3GetBoolean(Tissue *t, const uint32_t *r, size_t n, bool *v, size_t m) { (void)r, (void)n, (void)m; v[0] = t->value[RUPTURED] != 0.0; return 0; }
#endif
