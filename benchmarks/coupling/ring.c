/* One model of ring.h as an FMU, FMI 2.0 and FMI 3.0 in one library: -DSTART and -DSTEP choose it.
 */
#include "ring.h"
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <stdlib.h>
#include <string.h>

enum { N = 6 };
typedef struct {
    double x[N];
} Model;

static void start(Model *m) {
    const double x[N] = START;
    memcpy(m->x, x, sizeof x);
}

static Model *make(void) {
    Model *m = malloc(sizeof *m);
    if (m) {
        start(m);
    }
    return m;
}

static int set(Model *m, const unsigned r[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= N) {
            return 3;
        }
        m->x[r[i]] = v[i];
    }
    return 0;
}

static int get(const Model *m, const unsigned r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= N) {
            return 3;
        }
        v[i] = m->x[r[i]];
    }
    return 0;
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)callbacks;
    (void)visible, (void)logging;
    return make();
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Reset(fmi2Component c) { return start(c), fmi2OK; }
fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String s[]) {
    return (void)c, (void)on, (void)n, (void)s, fmi2OK;
}
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d,
                               fmi2Boolean e, fmi2Real f) {
    return (void)c, (void)a, (void)b, (void)d, (void)e, (void)f, fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n,
                       const fmi2Real v[]) {
    return (fmi2Status)set(c, r, n, v);
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    return (fmi2Status)get(c, r, n, v);
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean last) {
    (void)t, (void)last;
    STEP(((Model *)c)->x, h);
    return fmi2OK;
}

const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)events;
    (void)early, (void)required, (void)n, (void)environment, (void)log, (void)update;
    return make();
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3Reset(fmi3Instance c) { return start(c), fmi3OK; }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b, fmi3Float64 d,
                                       fmi3Boolean e, fmi3Float64 f) {
    return (void)c, (void)a, (void)b, (void)d, (void)e, (void)f, fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                          const fmi3Float64 v[], size_t n_values) {
    return (void)n_values, (fmi3Status)set(c, r, n, v);
}
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Float64 v[],
                          size_t n_values) {
    return (void)n_values, (fmi3Status)get(c, r, n, v);
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean last,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *reached) {
    (void)last;
    *event = *terminate = *early = false;
    *reached = t + h;
    STEP(((Model *)c)->x, h);
    return fmi3OK;
}
