/* An FMU that fails where it is told to: FMI 2.0 and FMI 3.0, Co-Simulation and Model Exchange, in
 * one library. x' = u - x, x(0) = k, y = x, n = 3.
 *
 * What fails is told by the token, "FUNCTION NTH STATUS", or by arm(): the n-th call of a function,
 * its name without fmi2 or fmi3, returns the status; NTH 0 is every call. A few words stand for
 * other faults: see the Fault enum. */
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SHOWN __attribute__((visibility("default")))
#ifndef ENVIRONMENT /* what the logger is given; the standard wants what the FMU was given */
#define ENVIRONMENT m->environment
#endif

enum { U, Y, X, DX, K, N };
typedef enum {
    NO_FAULT,
    OUTPUT,  /* y is NAN, infinite, minus infinite or denormal from t = 0.5 s on: status 0 .. 3 */
    FREEZE,  /* SetFMUstate restores nothing */
    NOTHING, /* GetFMUstate gives NULL */
    SIZE,    /* SerializedFMUstateSize gives 0, one more each time, or 2^60: status 0 .. 2 */
    LONG,    /* DoStep discards all steps longer than this many ms */
    SLOPE,   /* derivatives are NAN from t = 0.5 s on */
    EVENT,   /* the next event is at NAN, or is always now: status 0, 1 */
    STATES,  /* status 0: FMI 3.0 has 2^40 states */
    SAY,     /* the n-th DoStep logs the status, and returns OK */
    SILENT,  /* the n-th DoStep returns the status, and logs nothing */
    KEEP,    /* Reset does nothing, and initialisation leaves x as it is */
    N_FAULTS
} Fault;
static const char *const WORDS[] = {"",      "Output", "Freeze", "Nothing", "Size",   "Long",
                                    "Slope", "Event",  "States", "Say",     "Silent", "Keep"};

typedef struct {
    double u, x, k, t;
    int born; /* after so many fatal answers */
    fmi2CallbackLogger log2;
    fmi3LogMessageCallback log3;
    void *environment;
} Model;

static char function[64];
static int nth, status, calls, fatal, alive, states, abused;
static Fault fault;

SHOWN void arm(const char *plan) {
    calls = 0;
    nth = status = 0;
    function[0] = '\0';
    sscanf(plan, "%63s %d %d", function, &nth, &status);
    fault = NO_FAULT;
    for (int i = 1; i < N_FAULTS; i++) {
        fault = strcmp(function, WORDS[i]) == 0 ? (Fault)i : fault;
    }
}

/* Instances and states that were made and not freed; calls on instances that are corrupted. */
SHOWN void counts(int found[3]) {
    found[0] = alive;
    found[1] = states;
    found[2] = abused;
}

static bool ok(int answer) { return answer == 0 || answer == 1; }

static void say(Model *m) {
    if (m->log2) {
        m->log2(ENVIRONMENT, "faults", (fmi2Status)status, "x", "call %d broke %s%%n", calls,
                "%s%n");
    } else if (m->log3) {
        m->log3(ENVIRONMENT, (fmi3Status)status, "x", "it broke %s%n");
    }
}

static int answer(Model *m, const char *name) {
    abused += m->born < fatal;
    if (strcmp(name, function) != 0 || (++calls != nth && nth != 0)) {
        return 0;
    }
    say(m);
    fatal += status == 4;
    return status;
}

#define ANSWER(name)                                                                               \
    const int said = answer(c, name);                                                              \
    if (!ok(said))                                                                                 \
    return said
#define F2(name, ...) SHOWN fmi2Status fmi2##name(fmi2Component c __VA_OPT__(, ) __VA_ARGS__)
#define F3(name, ...) SHOWN fmi3Status fmi3##name(fmi3Instance c __VA_OPT__(, ) __VA_ARGS__)
#define SAME(name)                                                                                 \
    F2(name) { return (fmi2Status)plain(c, #name); }                                               \
    F3(name) { return (fmi3Status)plain(c, #name); }

static Model *make(const char *token) {
    if (strcmp(token, "armed elsewhere") != 0 && function[0] == '\0') {
        arm(token);
    }
    Model *m = calloc(1, sizeof *m);
    m->born = fatal;
    m->k = 1.0;
    alive++;
    return m;
}

static void discard(Model *m) {
    abused += m->born < fatal;
    alive--;
    free(m);
}

static int plain(Model *c, const char *name) {
    ANSWER(name);
    return said;
}

static int reset(Model *c) {
    ANSWER("Reset");
    if (fault == KEEP) {
        return said;
    }
    c->u = c->x = c->t = 0.0;
    c->k = 1.0;
    return said;
}

static int start(Model *c) {
    ANSWER("EnterInitializationMode");
    c->x = fault == KEEP ? c->x : c->k;
    return said;
}

static int set(Model *c, const char *name, const unsigned *r, size_t n, const double *v) {
    ANSWER(name);
    for (size_t i = 0; i < n; i++) {
        *(r[i] == U ? &c->u : r[i] == K ? &c->k : &c->x) = v[i];
    }
    return said;
}

static double output(const Model *c) {
    const double odd[] = {NAN, INFINITY, -INFINITY, 5e-324};
    return fault == OUTPUT && c->t >= 0.5 - 1e-9 ? odd[status] : c->x;
}

static double slope(const Model *c) { return fault == SLOPE && c->t >= 0.5 ? NAN : c->u - c->x; }

static int get(Model *c, const char *name, const unsigned *r, size_t n, double *v) {
    ANSWER(name);
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] == Y    ? output(c)
               : r[i] == U  ? c->u
               : r[i] == K  ? c->k
               : r[i] == DX ? slope(c)
                            : c->x;
    }
    return said;
}

static int step(Model *c, double t, double h) {
    ANSWER("DoStep");
    if ((fault == SAY || fault == SILENT) && ++calls == nth) {
        if (fault == SILENT) {
            return status;
        }
        say(c);
    }
    if (fault == LONG && h > 1.0001e-3 * nth) {
        c->x = NAN; /* spoilt, unless it is restored */
        return 2;
    }
    c->x += h * (c->u - c->x);
    c->t = t + h;
    return said;
}

static int save(Model *c, void **state) {
    ANSWER("GetState");
    if (fault == NOTHING) {
        return said;
    }
    states += *state == NULL;
    *state = *state ? *state : malloc(sizeof *c);
    memcpy(*state, c, sizeof *c);
    return said;
}

static int restore(Model *c, const Model *state) {
    ANSWER("SetState");
    if (fault != FREEZE) {
        c->u = state->u, c->x = state->x, c->k = state->k, c->t = state->t;
    }
    return said;
}

static int forget(Model *c, void **state) {
    states -= *state != NULL;
    free(*state);
    *state = NULL;
    ANSWER("FreeState");
    return said;
}

static int size_of(Model *c, size_t *size) {
    static size_t more = 0;
    ANSWER("SerializedSize");
    *size = fault != SIZE ? sizeof *c
            : status == 0 ? 0
            : status == 1 ? 64 + more++
                          : (size_t)1 << 60;
    return said;
}

static int serialize(Model *c, const void *state, void *bytes, size_t size) {
    ANSWER("Serialize");
    memcpy(bytes, state, size < sizeof *c ? size : sizeof *c);
    return said;
}

static int deserialize(Model *c, const void *bytes, size_t size, void **state) {
    ANSWER("Deserialize");
    states++;
    *state = calloc(1, sizeof *c);
    memcpy(*state, bytes, size < sizeof *c ? size : sizeof *c);
    return said;
}

static int set_time(Model *c, double t) {
    ANSWER("SetTime");
    c->t = t;
    return said;
}

static int vector(Model *c, const char *name, double *x, double value) {
    ANSWER(name);
    x[0] = value;
    return said;
}

SHOWN const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
SHOWN const char *fmi2GetVersion(void) { return "2.0"; }
SHOWN const char *fmi3GetVersion(void) { return "3.0"; }

SHOWN fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token,
                                    fmi2String resources, const fmi2CallbackFunctions *callbacks,
                                    fmi2Boolean visible, fmi2Boolean logging) {
    Model *m = make(token);
    m->log2 = callbacks->logger;
    m->environment = callbacks->componentEnvironment;
    return m;
}
SHOWN fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
    fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference required[],
    size_t n, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
    fmi3IntermediateUpdateCallback update) {
    Model *m = make(token);
    m->log3 = log;
    m->environment = environment;
    return m;
}
SHOWN fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token,
                                                fmi3String resources, fmi3Boolean visible,
                                                fmi3Boolean logging,
                                                fmi3InstanceEnvironment environment,
                                                fmi3LogMessageCallback log) {
    return fmi3InstantiateCoSimulation(name, token, resources, 0, 0, 0, 0, NULL, 0, environment,
                                       log, NULL);
}
SHOWN void fmi2FreeInstance(fmi2Component c) { discard(c); }
SHOWN void fmi3FreeInstance(fmi3Instance c) { discard(c); }
F2(Reset) { return (fmi2Status)reset(c); }
F3(Reset) { return (fmi3Status)reset(c); }
F2(SetupExperiment, fmi2Boolean a, fmi2Real b, fmi2Real t, fmi2Boolean d, fmi2Real e) {
    return (fmi2Status)plain(c, "SetupExperiment");
}
F2(EnterInitializationMode) { return (fmi2Status)start(c); }
F3(EnterInitializationMode, fmi3Boolean a, fmi3Float64 b, fmi3Float64 t, fmi3Boolean d,
   fmi3Float64 e) {
    return (fmi3Status)start(c);
}
SAME(ExitInitializationMode)
SAME(Terminate)
SAME(EnterEventMode)
SAME(EnterContinuousTimeMode)
F3(EnterStepMode) { return (fmi3Status)plain(c, "EnterStepMode"); }
F2(CancelStep) { return (fmi2Status)plain(c, "CancelStep"); }
F2(GetBooleanStatus, const fmi2StatusKind kind, fmi2Boolean *value) {
    *value = 0;
    return (fmi2Status)plain(c, "GetBooleanStatus");
}
F2(GetRealStatus, const fmi2StatusKind kind, fmi2Real *value) {
    *value = ((Model *)c)->t;
    return (fmi2Status)plain(c, "GetRealStatus");
}
F2(SetReal, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
    return (fmi2Status)set(c, "SetReal", r, n, v);
}
F2(GetReal, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    return (fmi2Status)get(c, "GetReal", r, n, v);
}
F3(SetFloat64, const fmi3ValueReference r[], size_t n, const fmi3Float64 v[], size_t nv) {
    return (fmi3Status)set(c, "SetReal", r, n, v);
}
F3(GetFloat64, const fmi3ValueReference r[], size_t n, fmi3Float64 v[], size_t nv) {
    return (fmi3Status)get(c, "GetReal", r, n, v);
}
F2(GetInteger, const fmi2ValueReference r[], size_t n, fmi2Integer v[]) {
    v[0] = 3;
    return (fmi2Status)plain(c, "GetInteger");
}
F3(GetInt32, const fmi3ValueReference r[], size_t n, fmi3Int32 v[], size_t nv) {
    v[0] = 3;
    return (fmi3Status)plain(c, "GetInteger");
}
F2(DoStep, fmi2Real t, fmi2Real h, fmi2Boolean final) { return (fmi2Status)step(c, t, h); }
F3(DoStep, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final, fmi3Boolean *event,
   fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *reached) {
    *event = *terminate = *early = false;
    *reached = t + h;
    return (fmi3Status)step(c, t, h);
}
F2(GetFMUstate, fmi2FMUstate *s) { return (fmi2Status)save(c, s); }
F3(GetFMUState, fmi3FMUState *s) { return (fmi3Status)save(c, s); }
F2(SetFMUstate, fmi2FMUstate s) { return (fmi2Status)restore(c, s); }
F3(SetFMUState, fmi3FMUState s) { return (fmi3Status)restore(c, s); }
F2(FreeFMUstate, fmi2FMUstate *s) { return (fmi2Status)forget(c, s); }
F3(FreeFMUState, fmi3FMUState *s) { return (fmi3Status)forget(c, s); }
F2(SerializedFMUstateSize, fmi2FMUstate s, size_t *n) { return (fmi2Status)size_of(c, n); }
F3(SerializedFMUStateSize, fmi3FMUState s, size_t *n) { return (fmi3Status)size_of(c, n); }
F2(SerializeFMUstate, fmi2FMUstate s, fmi2Byte b[], size_t n) {
    return (fmi2Status)serialize(c, s, b, n);
}
F3(SerializeFMUState, fmi3FMUState s, fmi3Byte b[], size_t n) {
    return (fmi3Status)serialize(c, s, b, n);
}
F2(DeSerializeFMUstate, const fmi2Byte b[], size_t n, fmi2FMUstate *s) {
    return (fmi2Status)deserialize(c, b, n, s);
}
F3(DeserializeFMUState, const fmi3Byte b[], size_t n, fmi3FMUState *s) {
    return (fmi3Status)deserialize(c, b, n, s);
}

/* Model Exchange */
F2(SetTime, fmi2Real t) { return (fmi2Status)set_time(c, t); }
F3(SetTime, fmi3Float64 t) { return (fmi3Status)set_time(c, t); }
F2(SetContinuousStates, const fmi2Real x[], size_t n) {
    ((Model *)c)->x = x[0];
    return (fmi2Status)plain(c, "SetContinuousStates");
}
F3(SetContinuousStates, const fmi3Float64 x[], size_t n) {
    ((Model *)c)->x = x[0];
    return (fmi3Status)plain(c, "SetContinuousStates");
}
F2(GetContinuousStates, fmi2Real x[], size_t n) {
    return (fmi2Status)vector(c, "GetContinuousStates", x, ((Model *)c)->x);
}
F3(GetContinuousStates, fmi3Float64 x[], size_t n) {
    return (fmi3Status)vector(c, "GetContinuousStates", x, ((Model *)c)->x);
}
F2(GetDerivatives, fmi2Real x[], size_t n) {
    return (fmi2Status)vector(c, "GetDerivatives", x, slope(c));
}
F3(GetContinuousStateDerivatives, fmi3Float64 x[], size_t n) {
    return (fmi3Status)vector(c, "GetDerivatives", x, slope(c));
}
F2(GetNominalsOfContinuousStates, fmi2Real x[], size_t n) {
    return (fmi2Status)vector(c, "GetNominals", x, 1.0);
}
F3(GetNominalsOfContinuousStates, fmi3Float64 x[], size_t n) {
    return (fmi3Status)vector(c, "GetNominals", x, 1.0);
}
F2(GetEventIndicators, fmi2Real z[], size_t n) {
    return (fmi2Status)plain(c, "GetEventIndicators");
}
F3(GetEventIndicators, fmi3Float64 z[], size_t n) {
    return (fmi3Status)plain(c, "GetEventIndicators");
}
F3(GetNumberOfContinuousStates, size_t *n) {
    *n = fault == STATES ? (size_t)1 << 40 : 1;
    return (fmi3Status)plain(c, "GetNumberOfContinuousStates");
}
F3(GetNumberOfEventIndicators, size_t *n) {
    *n = 0;
    return (fmi3Status)plain(c, "GetNumberOfEventIndicators");
}
F2(CompletedIntegratorStep, fmi2Boolean final, fmi2Boolean *event, fmi2Boolean *terminate) {
    *event = *terminate = 0;
    return (fmi2Status)plain(c, "CompletedIntegratorStep");
}
F3(CompletedIntegratorStep, fmi3Boolean final, fmi3Boolean *event, fmi3Boolean *terminate) {
    *event = *terminate = false;
    return (fmi3Status)plain(c, "CompletedIntegratorStep");
}
F2(NewDiscreteStates, fmi2EventInfo *info) {
    *info = (fmi2EventInfo){.nextEventTimeDefined = fault == EVENT,
                            .nextEventTime = status ? ((Model *)c)->t : NAN};
    return (fmi2Status)plain(c, "UpdateDiscreteStates");
}
F3(UpdateDiscreteStates, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals,
   fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    *again = *terminate = *nominals = *values = false;
    *defined = fault == EVENT;
    *next = status ? ((Model *)c)->t : NAN;
    return (fmi3Status)plain(c, "UpdateDiscreteStates");
}
