/* An FMU that fails where it is told to: FMI 2.0 and FMI 3.0, Co-Simulation and Model Exchange, in
 * one library. x' = u - x, x(0) = k, y = x, n = 3.
 *
 * What fails is told by the token, "FUNCTION NTH STATUS", or by arm(): the n-th call of a function,
 * its name without fmi2 or fmi3, returns the status; NTH 0 is every call. A few words stand for
 * other faults: see the Fault enum. A fourth word of the token tells what the logger is given. */
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SHOWN __attribute__((visibility("default")))

enum { U, Y, X, DX, K, N };
typedef enum {
    NO_FAULT,
    OUTPUT,  /* y is NAN, infinite, minus infinite or denormal from t = 0.5 s on: status 0 .. 3 */
    FREEZE,  /* SetFMUstate restores nothing */
    NOTHING, /* GetFMUstate gives NULL */
    SIZE_GIVEN, /* SerializedFMUstateSize gives 0, one more each time, or 2^60: status 0 .. 2 */
    LONG,       /* DoStep discards all steps longer than this many ms */
    SLOPE,      /* derivatives are NAN from t = 0.5 s on */
    EVENT,      /* the next event is at NAN, or is always now: status 0, 1 */
    STATES,     /* status 0: FMI 3.0 has 2^40 states */
    SAY,        /* the n-th DoStep logs the status, and returns OK */
    SILENT,     /* the n-th DoStep returns the status, and logs nothing */
    N_FAULTS
} Fault;
static const char *const WORDS[] = {"",      "Output", "Freeze", "Nothing", "Size",  "Long",
                                    "Slope", "Event",  "States", "Say",     "Silent"};

typedef struct {
    double u, x[1], k, t;
    int born; /* after so many fatal answers */
    fmi2CallbackLogger log2;
    fmi3LogMessageCallback log3;
    void *environment;
} Model;

static char function[64];
static int nth, status, astray, calls, fatal, alive, states, abused;
static Fault fault;

SHOWN void arm(const char *plan) {
    calls = 0;
    nth = status = astray = 0;
    function[0] = '\0';
    sscanf(plan, "%63s %d %d %d", function, &nth, &status, &astray);
    fault = NO_FAULT;
    for (int i = 1; i < N_FAULTS; i++)
        fault = strcmp(function, WORDS[i]) == 0 ? (Fault)i : fault;
}

/* Instances and states that were made and not freed; calls on instances that are corrupted. */
SHOWN void counts(int found[3]) {
    found[0] = alive;
    found[1] = states;
    found[2] = abused;
}

static bool ok(int answer) { return answer == 0 || answer == 1; }

static void say(Model *m) { /* the standard wants the environment that the FMU was given */
    char *const given = m->environment;
    void *const told[] = {given, (void *)1, NULL, m, (void *)-8, given + 1};
    if (m->log2) {
        m->log2(told[astray], "faults", (fmi2Status)status, "x", "call %d broke %s%%n", calls,
                "%s%n");
    } else if (m->log3) {
        m->log3(told[astray], (fmi3Status)status, "x", "it broke %s%n");
    }
}

static int answer(Model *m, const char *name) {
    abused += m->born < fatal;
    if (strcmp(name, function) != 0 || (++calls != nth && nth != 0))
        return 0;
    say(m);
    fatal += status == 4;
    return status;
}

#define ANSWER(name)                                                                               \
    const int said = answer(c, name);                                                              \
    if (!ok(said))                                                                                 \
    return said

static Model *make(const char *token, fmi2CallbackLogger log2, fmi3LogMessageCallback log3,
                   void *environment) {
    if (strcmp(token, "armed elsewhere") != 0 && function[0] == '\0')
        arm(token);
    Model *m = calloc(1, sizeof *m);
    m->born = fatal;
    m->k = 1.0;
    m->log2 = log2;
    m->log3 = log3;
    m->environment = environment;
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
    c->u = c->x[0] = c->t = 0.0;
    c->k = 1.0;
    return said;
}

static int begin(Model *c) {
    ANSWER("EnterInitializationMode");
    c->x[0] = c->k;
    return said;
}

static int set(Model *c, const unsigned *r, size_t n, const double *v) {
    ANSWER("SetReal");
    for (size_t i = 0; i < n; i++)
        *(r[i] == U ? &c->u : r[i] == K ? &c->k : &c->x[0]) = v[i];
    return said;
}

static double output(const Model *c) {
    const double odd[] = {NAN, INFINITY, -INFINITY, 5e-324};
    return fault == OUTPUT && c->t >= 0.5 - 1e-9 ? odd[status] : c->x[0];
}

static double slope(const Model *c) { return fault == SLOPE && c->t >= 0.5 ? NAN : c->u - c->x[0]; }

static int get(Model *c, const unsigned *r, size_t n, double *v) {
    ANSWER("GetReal");
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] == Y    ? output(c)
               : r[i] == U  ? c->u
               : r[i] == K  ? c->k
               : r[i] == DX ? slope(c)
                            : c->x[0];
    }
    return said;
}

static int step(Model *c, double t, double h) {
    ANSWER("DoStep");
    if ((fault == SAY || fault == SILENT) && ++calls == nth) {
        if (fault == SILENT)
            return status;
        say(c);
    }
    if (fault == LONG && h > 1.0001e-3 * nth) {
        c->x[0] = NAN; /* spoilt, unless it is restored */
        return 2;
    }
    c->x[0] += h * (c->u - c->x[0]);
    c->t = t + h;
    return said;
}

static void save(Model *c, void **s) {
    if (fault != NOTHING) {
        states += *s == NULL;
        *s = *s ? *s : malloc(sizeof *c);
        memcpy(*s, c, sizeof *c);
    }
}

static void restore(Model *c, const Model *state) {
    if (fault != FREEZE)
        c->u = state->u, c->x[0] = state->x[0], c->k = state->k, c->t = state->t;
}

static size_t size_of(void) {
    static size_t more = 0;
    return fault != SIZE_GIVEN ? sizeof(Model)
           : status == 0       ? 0
           : status == 1       ? 64 + more++
                               : (size_t)1 << 60;
}

#define MAKE                                                                                       \
    make(token, callbacks ? callbacks->logger : NULL, log,                                         \
         callbacks ? callbacks->componentEnvironment : environment)
#define FREE discard(m)
#define RESET reset(m)
#define SETUP (((Model *)m)->log3 ? 0 : plain(m, "SetupExperiment"))
#define ENTER begin(m)
#define LEAVE plain(m, "ExitInitializationMode")
#define TERMINATE plain(m, "Terminate")
#define STEP step(m, t, h)
#define CALLED(name) plain(m, name)
#define SAVES
#define TAKE(size) (states++, malloc(size))
#define GIVE(room) (states -= (room) != NULL, free(room))
#define SAVE save(m, s)
#define RESTORE restore(m, s)
#define SIZE size_of()
#define EXCHANGE
#define N_STATES (fault == STATES ? (size_t)1 << 40 : 1)
#define derivatives(m, dx) (dx[0] = slope(m))
#define UPDATE                                                                                     \
    info->nextEventTimeDefined = fault == EVENT,                                                   \
    info->nextEventTime = status ? ((Model *)m)->t : NAN
#include "fmu.h"

SHOWN fmi3Status fmi3EnterStepMode(fmi3Instance m) { return (fmi3Status)plain(m, "EnterStepMode"); }
SHOWN fmi2Status fmi2CancelStep(fmi2Component m) { return (fmi2Status)plain(m, "CancelStep"); }
SHOWN fmi2Status fmi2GetBooleanStatus(fmi2Component m, fmi2StatusKind kind, fmi2Boolean *value) {
    *value = fmi2False;
    return (fmi2Status)plain(m, "GetBooleanStatus");
}
SHOWN fmi2Status fmi2GetInteger(fmi2Component m, const unsigned r[], size_t n, fmi2Integer v[]) {
    v[0] = 3;
    return (fmi2Status)plain(m, "GetInteger");
}
SHOWN fmi3Status fmi3GetInt32(fmi3Instance m, const unsigned r[], size_t n, fmi3Int32 v[],
                              size_t values) {
    v[0] = 3;
    return (fmi3Status)plain(m, "GetInteger");
}
