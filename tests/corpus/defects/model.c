/* A small FMU of FMI 2.0 or 3.0 (-DFMI), both interfaces, that can have one defect.
 *
 * x' = -k x + u,  y = x + d u,  z = 2 x. The defect's name is patched into DEFECT after compiling.
 */
#define _GNU_SOURCE
#include <fenv.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#if FMI == 2
#include <fmi2Functions.h>
#define API(name) fmi2##name
#define NAMED(name2, name3) fmi2##name2
typedef fmi2String String;
typedef fmi2Byte Byte;
#define TOKEN "{reference-2}"
typedef fmi2Status Status;
typedef fmi2Boolean Bool;
typedef fmi2Component Handle;
#else
#include <fmi3Functions.h>
#define API(name) fmi3##name
#define NAMED(name2, name3) fmi3##name3
typedef fmi3String String;
typedef fmi3Byte Byte;
#define TOKEN "{reference-3}"
typedef fmi3Status Status;
typedef fmi3Boolean Bool;
typedef fmi3Instance Handle;
#endif

enum { TIME, U, X, DER_X, Y, Z, K, D, COUNT, INDICATOR, N, W, W_END = W + 3, MODE = W_END, SIZE };
enum { MADE, INITIALISING, RUNNING, ENDED };
enum { OK, WARN, DISCARD, FAILED };

typedef struct {
    double v[SIZE];
    int phase;
    double last; /* of the defect with a memory */
} State;

typedef struct {
    State s;
    const char *name;
    int logging;
#if FMI == 2
    const fmi2CallbackFunctions *callbacks;
#else
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
#endif
} Model;

static const volatile char DEFECT[40] = "DEFECT=none............................";
static State shared;

static int has(const char *name) {
    size_t k = 0;
    for (; name[k]; k++)
        if (DEFECT[7 + k] != name[k])
            return 0;
    return DEFECT[7 + k] == '.' || DEFECT[7 + k] == 0;
}

static State *of(Model *m) { return has("shared-state") ? &shared : &m->s; }

static void say(Model *m, int status, const char *category, const char *text) {
    if (status == OK && !m->logging && !has("logs-off"))
        return;
#if FMI == 2
    void *environment = m->callbacks->componentEnvironment;
#else
    void *environment = m->environment;
#endif
    environment = has("environment") ? (void *)1 : environment;
#if FMI == 2
    m->callbacks->logger(environment, m->name, (Status)status, category, text);
#else
    if (m->log || has("needs-logger"))
        m->log(environment, (Status)status, category, text);
#endif
}

static Status fail(Model *m, const char *text) {
    say(m, FAILED, has("category") ? "undeclared" : "logStatusError", text);
    return (Status)FAILED;
}

static double derivative(State *s) {
    const double rate = -s->v[K] * s->v[X] + s->v[U];
    if (has("derivative-nan"))
        return NAN;
    if (has("history")) {
        s->last += 1e-3;
        return rate + s->last;
    }
    return rate;
}

static void refresh(State *s) {
    s->v[DER_X] = derivative(s);
    s->v[Y] = s->v[X] + s->v[D] * s->v[U] * (has("nonlinear") ? 1 + s->v[U] : 1);
    s->v[Z] = 2 * s->v[X] + (has("feedthrough") ? 0.1 * s->v[U] : 0);
    s->v[INDICATOR] = s->v[X] + 100;
    if (has("output-nan") && s->v[TIME] > 0.25)
        s->v[Z] = NAN;
    if (has("leaves-range") && s->v[TIME] > 0.25)
        s->v[Z] = 1e6;
    if (has("exact-start") && s->phase == INITIALISING)
        s->v[Y] += s->v[W];
}

static void load(State *s) {
    const double k = s->v[K];
    memset(s, 0, sizeof *s);
    s->v[X] = 1;
    s->v[K] = has("other-start") ? 2.5 : has("reset-forgets") && k != 0 ? k : 2;
    s->v[D] = 0.5;
    s->v[N] = 3;
    s->v[MODE] = 1;
    for (int i = 0; i < 3; i++)
        s->v[W + i] = i + 1;
}

__attribute__((destructor)) static void unload(void) {
    if (has("unload"))
        abort();
}

static Model *make(const char *name, const char *token) {
    Model *m = calloc(1, sizeof *m);
    m->name = strdup(name);
    load(of(m));
    if (has("refuses-token") || (strcmp(token, TOKEN) != 0 && !has("any-token"))) {
        free(m);
        return NULL;
    }
    return m;
}

void API(FreeInstance)(Handle c) {
    Model *m = c;
    if (!m && !has("free-null"))
        return;
    if (!has("leak"))
        free((char *)m->name);
    free(m);
}

Status API(SetDebugLogging)(Handle c, Bool on, size_t n, const String names[]) {
    (void)n, (void)names;
    ((Model *)c)->logging = on;
    return (Status)(has("debug-logging") ? FAILED : OK);
}

static Status enter(Handle c, double start) {
    State *s = of(c);
    s->phase = INITIALISING;
    s->v[TIME] = start;
    refresh(s);
    return (Status)OK;
}

Status API(ExitInitializationMode)(Handle c) {
    Model *m = c;
    if (has("hang"))
        for (volatile int i = 0;; i++)
            ;
    if (has("locale-folder") && chdir("/"))
        return fail(m, "no root");
    if (has("rounding"))
        fesetround(FE_UPWARD);
    if (has("prints"))
        puts("hello from the FMU");
    of(m)->phase = RUNNING;
    say(m, OK, has("category") ? "undeclared" : "logEvents",
        has("null-message") ? NULL : "initialised");
    return (Status)OK;
}

#pragma clang diagnostic ignored "-Winfinite-recursion"
static int deep(volatile char *below) {
    volatile char room[1000];
    room[0] = below ? below[0] : 0;
    return deep(room) + room[0];
}

static Status step(Model *m, double time, double h) {
    State *s = of(m);
    if (s->phase != RUNNING && !has("step-any-time"))
        return fail(m, "not running");
    if (!(h > 0) && !has("zero-step"))
        return fail(m, "the step must be above 0");
    if (has("fixed-step") && h != 0.1)
        return fail(m, "the step must be 0.1");
    if (has("step-fails") && s->v[COUNT] > 2)
        return fail(m, "no more");
    if (has("crash"))
        *(volatile int *)8 = 1;
    if (has("abort"))
        abort();
    if (has("stack"))
        return (Status)(deep(NULL) > 300);
    if (has("exit"))
        exit(0);
    while (has("flood"))
        puts("and on and on and on and on");
    if (has("random"))
        s->v[X] += 1e-9 * (double)(clock() % 1000 + 1) * (double)rand() / RAND_MAX;
    if (has("process"))
        s->v[X] += 1e-9 * getpid();
    if (has("parameter-moves"))
        s->v[D] += 0.01;
    s->v[X] += h * derivative(s);
    s->v[COUNT] += 1;
    s->v[TIME] = has("time") ? time : time + h;
    refresh(s);
    return (Status)(has("warns") ? WARN : OK);
}

Status API(Terminate)(Handle c) {
    of(c)->phase = ENDED;
    return (Status)(has("terminate") ? FAILED : OK);
}

Status API(Reset)(Handle c) {
    load(of(c));
    return (Status)(has("reset-fails") ? FAILED : OK);
}

static Status get(Model *m, unsigned reference, double *value) {
    State *s = of(m);
    if (reference >= SIZE) {
        *value = 0;
        return has("any-reference") ? (Status)OK : fail(m, "no such variable");
    }
    if (has("getter"))
        s->v[X] *= 1.000001;
    if (s->phase == INITIALISING || s->phase == RUNNING)
        refresh(s);
    *value = s->v[reference];
    return (Status)OK;
}

static Status set(Model *m, unsigned reference, double value) {
    State *s = of(m);
    if (reference >= SIZE)
        return has("any-reference") ? (Status)OK : fail(m, "no such variable");
    if (has("set-lost") && reference == K)
        return (Status)OK;
    if ((has("set-refused") && reference == K) ||
        (has("input-stuck") && reference == U && value != 0))
        return fail(m, "not now");
    s->v[reference] = value;
    return (Status)OK;
}

/* The state, saved and serialised. */

Status NAMED(GetFMUstate, GetFMUState)(Handle c, void **copy) {
    State *s = of(c);
    *copy = *copy ? *copy : calloc(1, sizeof *s);
    memcpy(*copy, s, sizeof *s);
    if (has("saving-moves"))
        s->v[X] += 1e-3;
    return (Status)OK;
}

Status NAMED(SetFMUstate, SetFMUState)(Handle c, void *copy) {
    State *s = of(c);
    const double x = s->v[X];
    memcpy(s, copy, sizeof *s);
    if (has("restore-forgets"))
        s->v[X] = x;
    return (Status)OK;
}

Status NAMED(FreeFMUstate, FreeFMUState)(Handle c, void **copy) {
    (void)c;
    free(*copy);
    if (!has("freed-stays"))
        *copy = NULL;
    return (Status)OK;
}

Status NAMED(SerializedFMUstateSize, SerializedFMUStateSize)(Handle c, void *copy, size_t *size) {
    *size = sizeof(State);
    return (Status)(c && copy ? OK : FAILED);
}

Status NAMED(SerializeFMUstate, SerializeFMUState)(Handle c, void *copy, Byte bytes[],
                                                   size_t size) {
    (void)c;
    memcpy(bytes, copy, size);
    if (has("bytes-lose"))
        ((State *)(void *)bytes)->v[X] = 0;
    if (has("bytes-point")) { /* an address means nothing in another process */
        State *kept = malloc(size);
        memcpy(kept, copy, size);
        ((State *)(void *)bytes)->last = 0;
        memcpy(&((State *)(void *)bytes)->last, &kept, sizeof kept);
        ((State *)(void *)bytes)->v[X] = getpid();
    }
    return (Status)OK;
}

Status NAMED(DeSerializeFMUstate, DeserializeFMUState)(Handle c, const Byte bytes[], size_t size,
                                                       void **copy) {
    (void)c;
    *copy = malloc(size);
    memcpy(*copy, bytes, size);
    if (has("bytes-point")) {
        State *kept = NULL;
        memcpy(&kept, &((State *)*copy)->last, sizeof kept);
        if ((int)((State *)*copy)->v[X] == getpid())
            memcpy(*copy, kept, size);
    }
    return (Status)OK;
}

/* d unknown / d known */
static double slope(const State *s, unsigned unknown, unsigned known) {
    if (has("slope") && unknown == Y && known == U)
        return 2 * s->v[D];
    if (known == U)
        return unknown == DER_X ? 1 : unknown == Y ? s->v[D] : 0;
    if (known == X)
        return unknown == DER_X ? -s->v[K] : unknown == Y ? 1 : unknown == Z ? 2 : 0;
    return 0;
}

/* Model Exchange */

Status API(SetTime)(Handle c, double time) {
    of(c)->v[TIME] = time;
    return (Status)OK;
}

Status API(SetContinuousStates)(Handle c, const double x[], size_t n) {
    if (n == 1 && !has("states-lost"))
        of(c)->v[X] = x[0];
    return (Status)OK;
}

Status API(GetContinuousStates)(Handle c, double x[], size_t n) {
    if (n == 1)
        x[0] = of(c)->v[X];
    return (Status)OK;
}

Status API(GetNominalsOfContinuousStates)(Handle c, double x[], size_t n) {
    if (c && n == 1)
        x[0] = has("nominal") ? 0 : 1;
    return (Status)OK;
}

Status API(GetEventIndicators)(Handle c, double z[], size_t n) {
    refresh(of(c));
    z[0] = of(c)->v[INDICATOR];
    if (has("indicators"))
        z[n] = 1;
    return (Status)OK;
}

Status NAMED(GetDerivatives, GetContinuousStateDerivatives)(Handle c, double f[], size_t n) {
    if (n == 1)
        f[0] = derivative(of(c));
    return (Status)OK;
}

Status API(EnterContinuousTimeMode)(Handle c) { return (Status)(c ? OK : FAILED); }
Status API(EnterEventMode)(Handle c) { return (Status)(c ? OK : FAILED); }

Status API(CompletedIntegratorStep)(Handle c, Bool no, Bool *event, Bool *end) {
    *event = *end = 0;
    return (Status)(c || no ? OK : FAILED);
}

#if FMI == 2
#include "fmi2.h"
#else
#include "fmi3.h"
#endif
