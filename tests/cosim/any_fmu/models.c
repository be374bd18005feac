/* FMUs with all that our own models lack, FMI 2.0 and FMI 3.0, Model Exchange and Co-Simulation,
 * one of the MODELs a library. Co-Simulation is explicit Euler with one internal step of at most
 * 1/64 s. A value reference is a place in the table of values; arrays reach over the places behind
 * it. */
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FEEDTHROUGH, STATE_SPACE, BALL, OSCILLATOR, STAIR, CLOCKED };
enum { N_VALUES = 256, MAX_X = 8 };

typedef union {
    double d;  /* floating point */
    int64_t i; /* integers, Boolean */
    uint64_t u;
    char text[32];
} Value;

typedef struct {
    Value v[N_VALUES];
    double t, x[MAX_X], next_event, z_before;
    bool exchange, event_mode, early, terminate, configuring, initializing, running;
    const fmi2CallbackFunctions *callbacks;
} Model;

/* place in the table */
enum { SUM = 100, S, BYTES, BIG, N_BYTES, TOLD };   /* FEEDTHROUGH; 0 .. 29 in, 30 .. 59 out */
enum { N, A, U = A + 64, Y = U + 8, X0 = Y + 8 };   /* STATE_SPACE */
enum { H, V, G, E, BOUNCES, HEIGHT };               /* BALL */
enum { POS, VEL, K, FORCE, GAIN, EVENTS };          /* OSCILLATOR */
enum { COUNT, PERIOD, LAST, TRIGGER, SEEN, LEVEL }; /* STAIR */
/* CLOCKED: clocks, whether they tick, how often they did, the time of the last; 5 each */
enum { EVERY, GROWING, AFTER, BY_HAND, ASKED, N_CLOCKS, TICKED = 5, TICKS = 10, AT = 15 };

static void start(Model *m) {
    memset(m->v, 0, sizeof m->v);
    m->t = 0.0;
    m->next_event = INFINITY;
    m->terminate = m->initializing = m->running = false;
    if (MODEL == STATE_SPACE) {
        m->v[N].i = 3;
        for (int i = 0; i < 9; i++) {
            m->v[A + i].d = i % 4 == 0 ? -1.0 : 0.0;
        }
    } else if (MODEL == BALL) {
        m->v[H].d = 1.0;
        m->v[G].d = -9.81;
        m->v[E].d = 0.7;
    } else if (MODEL == OSCILLATOR) {
        m->v[POS].d = 1.0;
        m->v[K].d = 4.0;
    } else if (MODEL == STAIR) {
        m->v[PERIOD].d = 0.25;
        m->v[LAST].i = 1000;
    }
}

static size_t n_states(const Model *m) {
    return MODEL == STATE_SPACE ? (size_t)m->v[N].i : MODEL == BALL || MODEL == OSCILLATOR ? 2 : 0;
}
static size_t n_indicators(void) { return MODEL == BALL; }

static void read_states(Model *m) {
    for (size_t i = 0; i < n_states(m); i++) {
        m->x[i] = m->v[(MODEL == STATE_SPACE ? X0 : 0) + i].d;
    }
    if (MODEL == STAIR) {
        m->next_event = m->t + m->v[PERIOD].d;
    }
}

/* The tolerance of its own solver that it is told, 0 where it is told none. */
static void setup(Model *m, double t, bool told, double tolerance) {
    m->t = t;
    m->v[TOLD].d = told ? tolerance : 0.0;
}

/* By the standard inputs cannot be set before Initialization Mode. */
static bool allowed(const Model *m, unsigned reference) {
    return MODEL != FEEDTHROUGH || reference >= 30 || m->initializing || m->running;
}

static void begin(Model *m) {
    read_states(m);
    m->running = true;
}

static void derivatives(const Model *m, double *dx) {
    const size_t n = n_states(m);
    if (MODEL == STATE_SPACE) {
        for (size_t i = 0; i < n; i++) {
            dx[i] = m->v[U + i].d;
            for (size_t j = 0; j < n; j++) {
                dx[i] += m->v[A + i * n + j].d * m->x[j];
            }
        }
    } else if (MODEL == BALL) {
        dx[0] = m->x[1];
        dx[1] = m->v[G].d;
    } else if (MODEL == OSCILLATOR) {
        dx[0] = m->x[1];
        dx[1] = -m->v[K].d * m->x[0] + m->v[FORCE].d;
    }
}

static void outputs(Model *m) {
    if (!m->running) {
        read_states(m); /* as they were set so far */
    }
    if (MODEL == FEEDTHROUGH) {
        memcpy(m->v + 30, m->v, 30 * sizeof *m->v);
        m->v[SUM].d = (double)strlen(m->v[S].text) + 100.0 * (double)m->v[N_BYTES].i +
                      (double)(m->v[BIG].i % 1000003);
    } else if (MODEL == STATE_SPACE) {
        for (size_t i = 0; i < n_states(m); i++) {
            m->v[Y + i].d = m->x[i];
        }
    } else if (MODEL == BALL) {
        m->v[HEIGHT].d = m->x[0];
        m->v[H].d = m->x[0];
        m->v[V].d = m->x[1];
    } else if (MODEL == OSCILLATOR) {
        m->v[POS].d = m->x[0];
        m->v[VEL].d = m->x[1];
        m->v[GAIN].d = 2.0 * m->v[FORCE].d;
    }
}

static double indicator(const Model *m) { return m->x[0]; }

static bool due(const Model *m) {
    return (MODEL == BALL && m->x[0] <= 0.0 && m->x[1] < 0.0) ||
           (MODEL == STAIR && m->t >= m->next_event - 1e-12);
}

static void update(Model *m) {
    for (int i = 0; MODEL == CLOCKED && i < N_CLOCKS; i++) {
        if (m->v[TICKED + i].i) {
            m->v[TICKED + i].i = 0;
            m->v[TICKS + i].i++;
            m->v[AT + i].d = m->t;
        }
    }
    if (MODEL == BALL && due(m)) {
        m->x[0] = 1e-300;
        m->x[1] = m->v[BOUNCES].i < 20 ? -m->v[E].d * m->x[1] : 0.0;
        m->v[G].d = m->v[BOUNCES].i < 20 ? m->v[G].d : 0.0; /* it comes to rest */
        m->v[BOUNCES].i++;
    } else if (MODEL == STAIR) {
        if (due(m)) {
            m->v[COUNT].i++;
            m->next_event += m->v[PERIOD].d;
            m->terminate = m->v[COUNT].i >= m->v[LAST].i;
        }
        if (m->v[TRIGGER].i != m->v[SEEN].i) {
            m->v[SEEN].i = m->v[TRIGGER].i;
            m->v[LEVEL].i += 10;
        }
    }
}

/* Co-Simulation: to the end of the step, or to the first event where events are left to the master.
 * Returns whether there was an event. */
static bool step(Model *m, double end) {
    double dx[MAX_X];
    while (m->t < end - 1e-12) {
        const double next = fmin(end, m->t + 0.015625), h = next - m->t;
        derivatives(m, dx);
        for (size_t i = 0; i < n_states(m); i++) {
            m->x[i] += h * dx[i];
        }
        m->t = next;
        if (due(m)) {
            if (m->event_mode) {
                return true;
            }
            update(m);
            if (m->terminate) {
                return true;
            }
        }
    }
    if (!m->event_mode) {
        update(m);
    }
    return false;
}

/* Typed access: one body for all types. */
#define ACCESS(prefix, name, type, member, TAIL, SIZES)                                            \
    prefix##Status prefix##Set##name(void *c, const unsigned r[], size_t n,                        \
                                     const type values[] TAIL) {                                   \
        Model *m = c;                                                                              \
        SIZES;                                                                                     \
        for (size_t i = 0, k = 0; i < n; i++) {                                                    \
            if (!allowed(m, r[i])) {                                                               \
                return prefix##Error;                                                              \
            }                                                                                      \
            for (size_t j = 0; j < length(m, r[i]); j++) {                                         \
                m->v[r[i] + j].member = values[k++];                                               \
            }                                                                                      \
        }                                                                                          \
        return prefix##OK;                                                                         \
    }                                                                                              \
    prefix##Status prefix##Get##name(void *c, const unsigned r[], size_t n, type values[] TAIL) {  \
        Model *m = c;                                                                              \
        SIZES;                                                                                     \
        outputs(m);                                                                                \
        for (size_t i = 0, k = 0; i < n; i++) {                                                    \
            for (size_t j = 0; j < length(m, r[i]); j++) {                                         \
                values[k++] = (type)m->v[r[i] + j].member;                                         \
            }                                                                                      \
        }                                                                                          \
        return prefix##OK;                                                                         \
    }
static size_t length(const Model *m, unsigned r) {
    const size_t size = (size_t)m->v[N].i;
    return MODEL != STATE_SPACE || r == N ? 1 : r == A ? size * size : size;
}
#define NOTHING
#define COUNTED , size_t n_values
ACCESS(fmi2, Real, fmi2Real, d, NOTHING, (void)0)
ACCESS(fmi2, Integer, fmi2Integer, i, NOTHING, (void)0)
ACCESS(fmi2, Boolean, fmi2Boolean, i, NOTHING, (void)0)
#define ACCESS3(name, type, member) ACCESS(fmi3, name, type, member, COUNTED, (void)n_values)
ACCESS3(Float64, double, d)
ACCESS3(Float32, float, d)
ACCESS3(Int8, int8_t, i)
ACCESS3(UInt8, uint8_t, i)
ACCESS3(Int16, int16_t, i)
ACCESS3(UInt16, uint16_t, i)
ACCESS3(Int32, int32_t, i)
ACCESS3(UInt32, uint32_t, i)
ACCESS3(Int64, int64_t, i)
ACCESS3(UInt64, uint64_t, u)
ACCESS3(Boolean, bool, i)
fmi2Status fmi2SetString(void *c, const unsigned r[], size_t n, const fmi2String v[]) {
    for (size_t i = 0; i < n; i++) {
        snprintf(((Model *)c)->v[r[i]].text, 32, "%s", v[i]);
    }
    return fmi2OK;
}
fmi3Status fmi3SetString(void *c, const unsigned r[], size_t n, const fmi3String v[], size_t nv) {
    return (void)nv, (fmi3Status)fmi2SetString(c, r, n, v);
}
fmi3Status fmi3SetBinary(void *c, const unsigned r[], size_t n, const size_t sizes[],
                         const fmi3Binary v[], size_t nv) {
    (void)nv, (void)r, (void)v;
    ((Model *)c)->v[N_BYTES].i = n ? (int64_t)sizes[0] : 0;
    return fmi3OK;
}

static Model *create(bool exchange) {
    Model *m = calloc(1, sizeof *m);
    if (m) {
        m->exchange = exchange;
        start(m);
    }
    return m;
}

/* FMI 2.0 */
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)name, (void)guid, (void)callbacks, (void)visible, (void)logging;
    return strncmp(resources, "file:///", 8) == 0 ? create(type == fmi2ModelExchange) : NULL;
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Reset(fmi2Component c) { return start(c), fmi2OK; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real t,
                               fmi2Boolean e, fmi2Real f) {
    (void)e, (void)f;
    return setup(c, t, a, b), fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    return ((Model *)c)->initializing = true, fmi2OK;
}
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return begin(c), fmi2OK; }
fmi2Status fmi2EnterEventMode(fmi2Component c) {
    ((Model *)c)->v[EVENTS].i += MODEL == OSCILLATOR;
    return fmi2OK;
}
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean last) {
    Model *m = c;
    (void)last;
    step(m, t + h);
    return m->terminate ? fmi2Discard : fmi2OK;
}
fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
    *value = kind == fmi2Terminated && ((Model *)c)->terminate;
    return fmi2OK;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real *value) {
    (void)kind;
    return *value = ((Model *)c)->t, fmi2OK;
}
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    Model *m = c;
    update(m);
    *info = (fmi2EventInfo){.terminateSimulation = m->terminate,
                            .valuesOfContinuousStatesChanged = fmi2True,
                            .nextEventTimeDefined = isfinite(m->next_event),
                            .nextEventTime = m->next_event};
    return fmi2OK;
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set, fmi2Boolean *enter,
                                       fmi2Boolean *terminate) {
    (void)c, (void)no_set;
    return *enter = *terminate = fmi2False, fmi2OK;
}
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) { return ((Model *)c)->t = t, fmi2OK; }
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    return memcpy(x, ((Model *)c)->x, n * sizeof *x), fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    return memcpy(((Model *)c)->x, x, n * sizeof *x), fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    return (void)n, derivatives(c, dx), fmi2OK;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    return n ? (z[0] = indicator(c)), fmi2OK : fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    (void)c;
    for (size_t i = 0; i < n; i++) {
        x[i] = 1.0;
    }
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    *state = *state ? *state : malloc(sizeof(Model));
    return *state ? memcpy(*state, c, sizeof(Model)), fmi2OK : fmi2Error;
}
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    return memcpy(c, state, sizeof(Model)), fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    (void)c;
    free(*state);
    return *state = NULL, fmi2OK;
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *size) {
    (void)c, (void)s;
    return *size = sizeof(Model), fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte room[], size_t size) {
    return (void)c, memcpy(room, s, size), fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte room[], size_t size,
                                   fmi2FMUstate *s) {
    return (void)size,
           fmi2GetFMUstate(c, s) == fmi2OK ? (memcpy(*s, room, sizeof(Model)), fmi2OK) : fmi2Error;
}

/* FMI 3.0: the same, but for the arguments */
const char *fmi3GetVersion(void) { return "3.0"; }
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback intermediate) {
    (void)name, (void)token, (void)visible, (void)logging, (void)required, (void)n;
    (void)environment, (void)log, (void)intermediate;
    const size_t end = strlen(resources);
    Model *m = resources[end - 1] == '/' || resources[end - 1] == '\\' ? create(false) : NULL;
    if (m) {
        m->event_mode = events;
        m->early = early;
    }
    return m;
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)log;
    return create(true);
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *state) {
    return (fmi3Status)fmi2GetFMUstate(c, state);
}
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState state) {
    return (fmi3Status)fmi2SetFMUstate(c, state);
}
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *state) {
    return (fmi3Status)fmi2FreeFMUstate(c, state);
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState s, size_t *size) {
    return (fmi3Status)fmi2SerializedFMUstateSize(c, s, size);
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState s, fmi3Byte room[], size_t size) {
    return (void)c, memcpy(room, s, size), fmi3OK;
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte room[], size_t size,
                                   fmi3FMUState *s) {
    return (fmi3Status)fmi2DeSerializeFMUstate(c, (const fmi2Byte *)room, size, s);
}
fmi3Status fmi3Reset(fmi3Instance c) { return start(c), fmi3OK; }
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) {
    return ((Model *)c)->configuring = true, fmi3OK;
}
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) {
    return ((Model *)c)->configuring = false, fmi3OK;
}
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b, fmi3Float64 t,
                                       fmi3Boolean e, fmi3Float64 f) {
    (void)e, (void)f;
    setup(c, t, a, b);
    return ((Model *)c)->initializing = true, fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return begin(c), fmi3OK; }
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return (fmi3Status)fmi2EnterEventMode(c); }
fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                        const fmi3Clock values[]) {
    for (size_t i = 0; i < n; i++) {
        ((Model *)c)->v[TICKED + r[i]].i = values[i];
    }
    return fmi3OK;
}
/* GROWING doubles with every tick. AFTER ticks 0.1 s after the second tick of EVERY, and once more
 * at the same time. */
fmi3Status fmi3GetIntervalDecimal(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                                  fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[]) {
    const Model *m = c;
    const bool second = m->v[TICKS + EVERY].i == 2 && m->v[AT + EVERY].d == m->t;
    const bool repeat = m->v[TICKS + AFTER].i == 1 && m->v[AT + AFTER].d == m->t;
    for (size_t i = 0; i < n; i++) {
        qualifiers[i] = fmi3IntervalChanged;
        if (r[i] == AFTER) {
            qualifiers[i] = second || repeat ? fmi3IntervalChanged : fmi3IntervalNotYetKnown;
            intervals[i] = repeat ? 0.0 : 0.1;
        } else {
            intervals[i] = r[i] == ASKED ? 0.4 : 0.1 * (double)(1 << m->v[TICKS + GROWING].i);
        }
    }
    return fmi3OK;
}
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *reached) {
    Model *m = c;
    (void)no_set;
    *event = false;
    while (m->t < t + h - 1e-12) {
        *event = step(m, t + h) || *event;
        if (m->early || m->terminate) {
            break;
        }
    }
    *early = m->early && m->t < t + h - 1e-12;
    *terminate = m->terminate;
    *reached = m->t;
    return fmi3OK;
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals, fmi3Boolean *states,
                                    fmi3Boolean *defined, fmi3Float64 *next) {
    fmi2EventInfo info;
    fmi2NewDiscreteStates(c, &info);
    *again = *nominals = false;
    *states = true;
    *terminate = info.terminateSimulation;
    *defined = info.nextEventTimeDefined;
    *next = info.nextEventTime;
    return fmi3OK;
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_set, fmi3Boolean *enter,
                                       fmi3Boolean *terminate) {
    (void)c, (void)no_set;
    return *enter = *terminate = false, fmi3OK;
}
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 t) { return ((Model *)c)->t = t, fmi3OK; }
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) {
    return *n = n_states(c), fmi3OK;
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) {
    return (void)c, *n = n_indicators(), fmi3OK;
}
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) {
    return (fmi3Status)fmi2GetContinuousStates(c, x, n);
}
fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) {
    return (fmi3Status)fmi2SetContinuousStates(c, x, n);
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 dx[], size_t n) {
    return (void)n, derivatives(c, dx), fmi3OK;
}
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 z[], size_t n) {
    return (fmi3Status)fmi2GetEventIndicators(c, z, n);
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) {
    return (fmi3Status)fmi2GetNominalsOfContinuousStates(c, x, n);
}
