/* One small FMU for the tests, FMI 2.0 and FMI 3.0 in one library. KIND 0: y = k u; KIND 1: y' = u,
 * y(0) = k. */
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if KIND == 0
#define TOKEN "gain"
#else
#define TOKEN "integrator"
#endif

enum { U, Y, K, FAULT_TIME, SUM, N_REALS };
enum { FAULT = N_REALS, N, FLAG, TEXT };
enum { GIVE_NAN = 10, TERMINATE, RETURN_EARLY, FAIL_TO_INITIALISE };

typedef struct {
    double real[N_REALS];
    int fault, n;
    bool flag;
    char text[32];
    const fmi2CallbackFunctions *callbacks;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Model;

static void start(Model *m) {
    const double reals[N_REALS] = {0.0, 0.0, 1.0, 1e9, 0.0};
    memcpy(m->real, reals, sizeof reals);
    m->fault = 0;
    m->n = 0;
    m->flag = false;
    m->text[0] = '\0';
}

static double value(const Model *m, unsigned reference) {
    if (reference == Y && KIND == 0) {
        return m->real[K] * m->real[U];
    }
    if (reference == SUM) {
        return m->n + 10 * m->flag + 100 * (double)strlen(m->text);
    }
    return m->real[reference];
}

static int complain(const Model *m, int status, double t) {
    char message[64];
    if (m->callbacks) {
        m->callbacks->logger(m->callbacks->componentEnvironment, "model", (fmi2Status)status,
                             "error", "broke at t = %g", t);
    } else {
        snprintf(message, sizeof message, "broke at t = %g", t);
        m->log(m->environment, (fmi3Status)status, "error", message);
    }
    return status;
}

static int step(Model *m, double t, double h) {
    if (t >= m->real[FAULT_TIME] && m->fault == GIVE_NAN) {
        m->real[Y] = NAN;
        m->real[K] = NAN;
    } else if (t >= m->real[FAULT_TIME] && m->fault > 1 && m->fault < GIVE_NAN) {
        return complain(m, m->fault, t);
    } else if (KIND == 1) {
        m->real[Y] += h * m->real[U];
    }
    return 0;
}

static int initialise(Model *m) {
    m->real[Y] = m->real[K];
    return m->fault == FAIL_TO_INITIALISE ? complain(m, 3, 0.0) : 0;
}

#define REALS(i)                                                                                   \
    if (r[i] >= N_REALS) {                                                                         \
        return 3;                                                                                  \
    }

/* FMI 2.0 */
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                              fmi2Boolean logging) {
    Model *m = calloc(1, sizeof *m);
    (void)name, (void)resources, (void)visible, (void)logging, (void)type;
    if (!m || strcmp(guid, TOKEN) != 0) {
        free(m);
        return NULL;
    }
    m->callbacks = callbacks;
    start(m);
    return m;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Reset(fmi2Component c) { return start(c), fmi2OK; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d,
                               fmi2Boolean e, fmi2Real f) {
    (void)c, (void)a, (void)b, (void)d, (void)e, (void)f;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (fmi2Status)initialise(c); }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n,
                       const fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) {
        REALS(i)
        ((Model *)c)->real[r[i]] = v[i];
    }
    return fmi2OK;
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) {
        REALS(i)
        v[i] = value(c, r[i]);
    }
    return fmi2OK;
}
fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n,
                          const fmi2Integer v[]) {
    for (size_t i = 0; i < n; i++) {
        *(r[i] == N ? &((Model *)c)->n : &((Model *)c)->fault) = v[i];
    }
    return fmi2OK;
}
fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n,
                          const fmi2Boolean v[]) {
    (void)r;
    return n ? (((Model *)c)->flag = v[0]), fmi2OK : fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n,
                         const fmi2String v[]) {
    (void)r;
    snprintf(((Model *)c)->text, 32, "%s", n ? v[0] : "");
    return fmi2OK;
}
fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n,
                          fmi2Integer v[]) {
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] == N ? ((Model *)c)->n : ((Model *)c)->fault;
    }
    return fmi2OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n,
                          fmi2Boolean v[]) {
    (void)r;
    return n ? (v[0] = ((Model *)c)->flag), fmi2OK : fmi2OK;
}
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String v[]) {
    (void)r;
    return n ? (v[0] = ((Model *)c)->text), fmi2OK : fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean last) {
    (void)last;
    return (fmi2Status)step(c, t, h);
}

/* FMI 3.0 */
const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    Model *m = calloc(1, sizeof *m);
    (void)name, (void)resources, (void)visible, (void)logging, (void)events, (void)early;
    (void)required, (void)n, (void)update;
    if (!m || strcmp(token, TOKEN) != 0) {
        free(m);
        return NULL;
    }
    m->log = log;
    m->environment = environment;
    start(m);
    return m;
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3Reset(fmi3Instance c) { return start(c), fmi3OK; }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b, fmi3Float64 d,
                                       fmi3Boolean e, fmi3Float64 f) {
    (void)a, (void)b, (void)d, (void)e, (void)f;
    return (fmi3Status)initialise(c);
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                          const fmi3Float64 v[], size_t nv) {
    return (void)nv, (fmi3Status)fmi2SetReal(c, r, n, v);
}
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Float64 v[],
                          size_t nv) {
    return (void)nv, (fmi3Status)fmi2GetReal(c, r, n, v);
}
fmi3Status fmi3SetInt32(fmi3Instance c, const fmi3ValueReference r[], size_t n, const fmi3Int32 v[],
                        size_t nv) {
    return (void)nv, (fmi3Status)fmi2SetInteger(c, r, n, v);
}
fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                          const fmi3Boolean v[], size_t nv) {
    (void)r, (void)nv;
    return n ? (((Model *)c)->flag = v[0]), fmi3OK : fmi3OK;
}
fmi3Status fmi3SetString(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                         const fmi3String v[], size_t nv) {
    return (void)nv, (fmi3Status)fmi2SetString(c, r, n, v);
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean last,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *reached) {
    const Model *m = c;
    const bool due = t >= m->real[FAULT_TIME];
    (void)last;
    *event = true; /* must not matter: event mode is not used */
    *terminate = due && m->fault == TERMINATE;
    *early = due && m->fault == RETURN_EARLY;
    *reached = *early ? t : t + h;
    return (fmi3Status)step(c, t, h);
}
