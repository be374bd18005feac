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

enum { FEEDTHROUGH, STATE_SPACE, BALL, OSCILLATOR, STAIR, CLOCKED, AMPLIFIER, INTEGRATOR };
enum { N_VALUES = 256, MAX_X = 8 };

typedef union {
    double d;  /* floating point */
    int64_t i; /* integers, Boolean */
    uint64_t u;
    char text[32];
} Value;

typedef struct {
    Value v[N_VALUES];
    double t, x[MAX_X], next_event;
    bool event_mode, early, terminate, initializing, running;
    const fmi2CallbackFunctions *callbacks;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Model;

/* place in the table */
enum { SUM = 100, S, BYTES, BIG, N_BYTES, TOLD };   /* FEEDTHROUGH; 0 .. 29 in, 30 .. 59 out */
enum { N, A, U = A + 64, Y = U + 8, X0 = Y + 8 };   /* STATE_SPACE */
enum { H, V, G, E, BOUNCES, HEIGHT };               /* BALL */
enum { POS, VEL, K, FORCE, GAIN, EVENTS };          /* OSCILLATOR */
enum { COUNT, PERIOD, LAST, TRIGGER, SEEN, LEVEL }; /* STAIR */
/* AMPLIFIER: y = k u; INTEGRATOR: y' = u, y(0) = k. From a time on both fail as their fault says: a
 * status, or one of those behind. */
enum { INPUT, SHOWN, FACTOR, FAULT_TIME, TOTAL, FAULT, WHOLE, FLAG, TEXT, SIGN };
enum { GIVE_NAN = 10, END, RETURN_EARLY };
/* CLOCKED: clocks, whether they tick, how often they did, the time of the last; 5 each */
enum {
    EVERY,
    GROWING,
    AFTER,
    BY_HAND,
    ASKED,
    N_CLOCKS,
    TICKED = 5,
    TICKS = 10,
    AT = 15,
    TOCK = 20
};

static void start(Model *m) {
    memset(m->v, 0, sizeof m->v);
    m->t = 0.0;
    m->next_event = INFINITY;
    m->terminate = m->initializing = m->running = false;
    if (MODEL == STATE_SPACE) {
        m->v[N].i = 3;
        for (int i = 0; i < 9; i++)
            m->v[A + i].d = i % 4 == 0 ? -1.0 : 0.0;
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
    } else if (MODEL == AMPLIFIER || MODEL == INTEGRATOR) {
        m->v[FACTOR].d = 1.0;
        m->v[FAULT_TIME].d = 1e9;
    }
}

static size_t n_states(const Model *m) {
    return MODEL == STATE_SPACE                   ? (size_t)m->v[N].i
           : MODEL == BALL || MODEL == OSCILLATOR ? 2
                                                  : MODEL == INTEGRATOR;
}

static void read_states(Model *m) {
    for (size_t i = 0; i < n_states(m); i++)
        m->x[i] = m->v[(MODEL == STATE_SPACE ? X0 : MODEL == INTEGRATOR ? FACTOR : 0) + i].d;
    if (MODEL == STAIR)
        m->next_event = m->t + m->v[PERIOD].d;
}

/* The tolerance of its own solver that it is told, 0 where it is told none. */
static int setup(Model *m, double t, bool told, double tolerance) {
    m->t = t;
    m->v[TOLD].d = told ? tolerance : 0.0;
    return 0;
}

static int initialise(Model *m) {
    m->initializing = true;
    return 0;
}

/* By the standard inputs cannot be set before Initialization Mode. */
static bool allowed(const Model *m, unsigned reference) {
    return MODEL != FEEDTHROUGH || reference >= 30 || m->initializing || m->running;
}

static int begin(Model *m) {
    read_states(m);
    m->running = true;
    return 0;
}

static void derivatives(const Model *m, double *dx) {
    const size_t n = n_states(m);
    if (MODEL == STATE_SPACE) {
        for (size_t i = 0; i < n; i++) {
            dx[i] = m->v[U + i].d;
            for (size_t j = 0; j < n; j++)
                dx[i] += m->v[A + i * n + j].d * m->x[j];
        }
    } else if (MODEL == BALL) {
        dx[0] = m->x[1];
        dx[1] = m->v[G].d;
    } else if (MODEL == OSCILLATOR) {
        dx[0] = m->x[1];
        dx[1] = -m->v[K].d * m->x[0] + m->v[FORCE].d;
    } else if (MODEL == INTEGRATOR) {
        dx[0] = m->v[INPUT].d;
    }
}

static void outputs(Model *m) {
    if (!m->running)
        read_states(m); /* as they were set so far */
    if (MODEL == FEEDTHROUGH) {
        memcpy(m->v + 30, m->v, 30 * sizeof *m->v);
        m->v[SUM].d = (double)strlen(m->v[S].text) + 100.0 * (double)m->v[N_BYTES].i +
                      (double)(m->v[BIG].i % 1000003);
    } else if (MODEL == STATE_SPACE) {
        for (size_t i = 0; i < n_states(m); i++)
            m->v[Y + i].d = m->x[i];
    } else if (MODEL == BALL) {
        m->v[HEIGHT].d = m->x[0];
        m->v[H].d = m->x[0];
        m->v[V].d = m->x[1];
    } else if (MODEL == OSCILLATOR) {
        m->v[POS].d = m->x[0];
        m->v[VEL].d = m->x[1];
        m->v[GAIN].d = 2.0 * m->v[FORCE].d;
    } else if (MODEL == AMPLIFIER || MODEL == INTEGRATOR) {
        m->v[SHOWN].d = MODEL == INTEGRATOR ? m->x[0] : m->v[FACTOR].d * m->v[INPUT].d;
        m->v[TOTAL].d = (double)m->v[WHOLE].i + 10.0 * (double)m->v[FLAG].i +
                        100.0 * (double)strlen(m->v[TEXT].text);
    }
}

static bool due(const Model *m) {
    return (MODEL == BALL && m->x[0] <= 0.0 && m->x[1] < 0.0) ||
           (MODEL == STAIR && m->t >= m->next_event - 1e-12);
}

static void update(Model *m) {
    m->v[TOCK].i = MODEL == CLOCKED ? 0 : m->v[TOCK].i;
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
        for (size_t i = 0; i < n_states(m); i++)
            m->x[i] += h * dx[i];
        m->t = next;
        if (due(m)) {
            if (m->event_mode)
                return true;
            update(m);
            if (m->terminate)
                return true;
        }
    }
    if (!m->event_mode)
        update(m);
    return false;
}

static void report(const Model *m, int status, const char *format, double number) {
    char message[64];
    if (m->callbacks) {
        m->callbacks->logger(m->callbacks->componentEnvironment, "model", (fmi2Status)status,
                             "error", format, number);
    } else {
        snprintf(message, sizeof message, format, number);
        m->log(m->environment, (fmi3Status)status, "error", message);
    }
}

/* A step of the last two, which may fail. */
static int simple_step(Model *m, double t, double h, bool *early, double *reached) {
    const int due = t >= m->v[FAULT_TIME].d ? (int)m->v[FAULT].i : 0;
    m->x[0] += h * m->v[INPUT].d;
    if (due == GIVE_NAN) {
        m->x[0] = m->v[FACTOR].d = NAN;
    } else if (due > 1 && due < GIVE_NAN) {
        report(m, 0, "cause %g", 1.0); /* before the error, as with Dymola */
        report(m, due, "broke at t = %g", t);
    }
    m->terminate = due == END;
    *early = due == RETURN_EARLY;
    *reached = *early ? t : t + h;
    return due < GIVE_NAN ? due : 0;
}

static int do_step(Model *m, double t, double h, bool *event, bool *terminate, bool *early,
                   double *reached) {
    const double end = t + h;
    if (MODEL == AMPLIFIER || MODEL == INTEGRATOR) {
        const int status = simple_step(m, t, h, early, reached);
        *terminate = m->terminate;
        return status;
    }
    while (m->t < end - 1e-12) {
        *event = step(m, end) || *event;
        if (m->early || m->terminate)
            break;
    }
    *early = m->early && m->t < end - 1e-12;
    *terminate = m->terminate;
    *reached = m->t;
    return 0;
}

/* Where the resources lie: a URI in FMI 2.0; in FMI 3.0 a path that ends in a separator, which
 * Model Exchange does not check. */
static bool well_placed(const char *resources, bool version_2, bool exchange) {
    const char end = resources[0] ? resources[strlen(resources) - 1] : '\0';
    return version_2 ? strncmp(resources, "file:///", 8) == 0
                     : exchange || end == '/' || end == '\\';
}

static Model *create(bool placed, Model given) {
    Model *m = placed ? malloc(sizeof *m) : NULL;
    if (m) {
        *m = given;
        start(m);
    }
    return m;
}

static int update_info(Model *m, fmi2EventInfo *info) {
    update(m);
    info->terminateSimulation = m->terminate;
    info->valuesOfContinuousStatesChanged = fmi2True;
    info->nextEventTimeDefined = isfinite(m->next_event);
    info->nextEventTime = m->next_event;
    return 0;
}

#define MAKE                                                                                       \
    create(well_placed(resources, callbacks, exchange), (Model){.event_mode = events,              \
                                                                .early = early,                    \
                                                                .callbacks = callbacks,            \
                                                                .log = log,                        \
                                                                .environment = environment})
#define SETUP setup(m, t, told, tolerance)
#define ENTER initialise(m)
#define LEAVE begin(m)
#define STEP do_step(m, t, h, event, terminate, early, reached)
#define SAVES
#define EXCHANGE
#define OWN_REALS
#define N_STATES n_states(m)
#define INDICATORS (MODEL == BALL)
#define INDICATE n ? z[0] = ((Model *)m)->x[0], 0 : 0
#define UPDATE update_info(m, info)
#define ENTER_EVENT_MODE (((Model *)m)->v[EVENTS].i += MODEL == OSCILLATOR, 0)
#include "fmu.h"

/* Typed access: one body for all types. */
#define ACCESS(fmi, Name, type, member, ...)                                                       \
    fmi##Status fmi##Set##Name(void *c, const unsigned r[], size_t n,                              \
                               const type v[] __VA_OPT__(, ) __VA_ARGS__) {                        \
        Model *m = c;                                                                              \
        for (size_t k = 0; k < n; k++) {                                                           \
            if (!allowed(m, r[k]))                                                                 \
                return fmi##Error;                                                                 \
            for (size_t i = 0; i < length(m, r[k]); i++)                                           \
                m->v[r[k] + i].member = *v++;                                                      \
        }                                                                                          \
        return fmi##OK;                                                                            \
    }                                                                                              \
    fmi##Status fmi##Get##Name(void *c, const unsigned r[], size_t n,                              \
                               type v[] __VA_OPT__(, ) __VA_ARGS__) {                              \
        Model *m = c;                                                                              \
        outputs(m);                                                                                \
        for (size_t k = 0; k < n; k++)                                                             \
            for (size_t i = 0; i < length(m, r[k]); i++)                                           \
                *v++ = (type)m->v[r[k] + i].member;                                                \
        return fmi##OK;                                                                            \
    }
static size_t length(const Model *m, unsigned r) {
    const size_t size = (size_t)m->v[N].i;
    return MODEL != STATE_SPACE || r == N ? 1 : r == A ? size * size : size;
}
ACCESS(fmi2, Real, fmi2Real, d, )
ACCESS(fmi2, Integer, fmi2Integer, i, )
ACCESS(fmi2, Boolean, fmi2Boolean, i, )
ACCESS(fmi3, Float64, double, d, size_t values)
ACCESS(fmi3, Float32, float, d, size_t values)
ACCESS(fmi3, Int8, int8_t, i, size_t values)
ACCESS(fmi3, UInt8, uint8_t, i, size_t values)
ACCESS(fmi3, Int16, int16_t, i, size_t values)
ACCESS(fmi3, UInt16, uint16_t, i, size_t values)
ACCESS(fmi3, Int32, int32_t, i, size_t values)
ACCESS(fmi3, UInt32, uint32_t, i, size_t values)
ACCESS(fmi3, Int64, int64_t, i, size_t values)
ACCESS(fmi3, UInt64, uint64_t, u, size_t values)
ACCESS(fmi3, Boolean, bool, i, size_t values)
fmi2Status fmi2SetString(void *c, const unsigned r[], size_t n, const fmi2String v[]) {
    for (size_t i = 0; i < n; i++)
        snprintf(((Model *)c)->v[r[i]].text, 32, "%s", v[i]);
    return fmi2OK;
}
fmi3Status fmi3SetString(void *c, const unsigned r[], size_t n, const fmi3String v[], size_t nv) {
    return (fmi3Status)fmi2SetString(c, r, n, v);
}
fmi2Status fmi2GetString(void *c, const unsigned r[], size_t n, fmi2String v[]) {
    Model *m = c;
    outputs(m);
    for (size_t i = 0; i < n; i++)
        v[i] = r[i] != SIGN ? m->v[r[i]].text : m->v[SHOWN].d > 0.0 ? "up" : "not \xc3\xbcp";
    return fmi2OK;
}
fmi3Status fmi3GetString(void *c, const unsigned r[], size_t n, fmi3String v[], size_t nv) {
    return (fmi3Status)fmi2GetString(c, r, n, v);
}
fmi3Status fmi3SetBinary(void *c, const unsigned r[], size_t n, const size_t sizes[],
                         const fmi3Binary v[], size_t nv) {
    ((Model *)c)->v[N_BYTES].i = n ? (int64_t)sizes[0] : 0;
    return fmi3OK;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
    *value = kind == fmi2Terminated && ((Model *)c)->terminate;
    return fmi2OK;
}
fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real *value) {
    return *value = ((Model *)c)->t, fmi2OK;
}
fmi3Status fmi3EnterConfigurationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3ExitConfigurationMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3EnterStepMode(fmi3Instance c) { return fmi3OK; }
fmi3Status fmi3SetClock(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                        const fmi3Clock values[]) {
    for (size_t i = 0; i < n; i++) {
        ((Model *)c)->v[TICKED + r[i]].i = values[i];
        ((Model *)c)->v[TOCK].i |= r[i] == EVERY || r[i] == BY_HAND;
    }
    return fmi3OK;
}
/* TOCK ticks with EVERY and BY_HAND. */
fmi3Status fmi3GetClock(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                        fmi3Clock values[]) {
    return values[n - 1] = ((Model *)c)->v[r[n - 1]].i != 0, fmi3OK;
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
