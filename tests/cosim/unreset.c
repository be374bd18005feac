/* An FMU whose reset is RESET, a statement on m; FMI 2.0 and FMI 3.0. Its output is
 * y = x + 10 (own time >= 0.35 s) + 100 (steps >= 12), x' = k u - z, z' = x; only y can be seen. */
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <stdbool.h>
#include <stdlib.h>

enum { U, Y, K };

typedef struct {
    double u, k, x, z, time;
    int steps;
} Model;

static int instances; /* that there were */

static Model fresh(void) { return (Model){.k = 0.1 + NOISE * instances, .u = 1.0}; }

static void *make(void) {
    Model *m = malloc(sizeof *m);
    instances++;
    *m = fresh();
    return m;
}

static int reset(Model *m) {
    const Model old = *m;
    (void)old;
    RESET
    return 0;
}

static int set(Model *m, const unsigned *r, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++) {
        *(r[i] == U ? &m->u : &m->k) = v[i];
    }
    return 0;
}

static int get(const Model *m, const unsigned *r, size_t n, double *v) {
    const double y = m->x + (m->time >= 0.349 ? 10.0 : 0.0) + (m->steps >= 12 ? 100.0 : 0.0);
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] == Y ? y : r[i] == U ? m->u : m->k;
    }
    return 0;
}

static int step(Model *m, double h) {
    m->x += h * (m->k * m->u - m->z);
    m->z += h * m->x;
    m->time += h;
    m->steps++;
    return 0;
}

#define ON2(name, ...) fmi2Status fmi2##name(fmi2Component c __VA_OPT__(, ) __VA_ARGS__)
#define ON3(name, ...) fmi3Status fmi3##name(fmi3Instance c __VA_OPT__(, ) __VA_ARGS__)

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                              fmi2Boolean logging) {
    return make();
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
#ifndef WITHOUT_RESET
ON2(Reset) { return (fmi2Status)reset(c); }
ON3(Reset) { return (fmi3Status)reset(c); }
#endif
ON2(SetupExperiment, fmi2Boolean a, fmi2Real b, fmi2Real d, fmi2Boolean e, fmi2Real f) {
    return fmi2OK;
}
ON2(EnterInitializationMode) { return fmi2OK; }
ON2(ExitInitializationMode) { return fmi2OK; }
ON2(Terminate) { return fmi2OK; }
ON2(SetReal, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
    return (fmi2Status)set(c, r, n, v);
}
ON2(GetReal, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    return (fmi2Status)get(c, r, n, v);
}
ON2(DoStep, fmi2Real t, fmi2Real h, fmi2Boolean last) { return (fmi2Status)step(c, h); }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    return make();
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
ON3(EnterInitializationMode, fmi3Boolean a, fmi3Float64 b, fmi3Float64 d, fmi3Boolean e,
    fmi3Float64 f) {
    return fmi3OK;
}
ON3(ExitInitializationMode) { return fmi3OK; }
ON3(Terminate) { return fmi3OK; }
ON3(SetFloat64, const fmi3ValueReference r[], size_t n, const fmi3Float64 v[], size_t nv) {
    return (fmi3Status)set(c, r, n, v);
}
ON3(GetFloat64, const fmi3ValueReference r[], size_t n, fmi3Float64 v[], size_t nv) {
    return (fmi3Status)get(c, r, n, v);
}
ON3(DoStep, fmi3Float64 t, fmi3Float64 h, fmi3Boolean last, fmi3Boolean *event,
    fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    *event = *terminate = *early = false;
    *reached = t + h;
    return (fmi3Status)step(c, h);
}
