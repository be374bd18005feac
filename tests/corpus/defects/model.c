/* A small FMU of FMI 2.0 and 3.0, both interfaces, that can have one defect.
 *
 * x' = -k x + u,  y = x + d u,  z = 2 x. The defect's name is patched into DEFECT after compiling.
 */
#define _GNU_SOURCE
#include <fcntl.h>
#include <fenv.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <fmi2Functions.h>
#include <fmi3Functions.h>

enum { TIME, U, X, DER_X, Y, Z, K, D, COUNT, INDICATOR, N, W, W_END = W + 3, MODE = W_END, SIZE };
enum { MADE, INITIALISING, RUNNING, ENDED };
enum { OK, WARN, FAILED = 3 };

typedef struct {
    double v[SIZE];
    int phase;
    double last; /* of the defect with a memory */
} State;

typedef struct {
    State s;
    const char *name;
    int logging;
    const fmi2CallbackFunctions *callbacks;
    fmi3LogMessageCallback log;
    void *environment;
} Model;

static const volatile char DEFECT[40] = "DEFECT=none............................";
static State shared;
static int instances;

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
    void *environment = has("environment") ? (void *)1 : m->environment;
    if (m->callbacks)
        m->callbacks->logger(environment, m->name, (fmi2Status)status, category, text);
    else if (m->log || has("needs-logger"))
        m->log(environment, (fmi3Status)status, category, text);
}

static int fail(Model *m, const char *text) {
    say(m, FAILED, has("category") ? "undeclared" : "logStatusError", text);
    return FAILED;
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

static Model *make(Model given, const char *token) {
    if (given.callbacks) {
        given.environment = given.callbacks->componentEnvironment;
        if (has("callbacks"))
            given.callbacks->freeMemory(given.callbacks->allocateMemory(1, 8));
    }
    const char *own = given.callbacks ? "{reference-2}" : "{reference-3}";
    if (has("refuses-token") || (strcmp(token, own) != 0 && !has("any-token")))
        return NULL;
    if (has("few-instances") && instances > 7)
        return NULL;
    instances++;
    Model *m = calloc(1, sizeof *m);
    *m = given;
    m->name = strdup(given.name);
    load(of(m));
    return m;
}

static void discard(Model *m) {
    if (!m && !has("free-null"))
        return;
    instances--;
    if (!has("leak"))
        free((char *)m->name);
    free(m);
}

static int enter(Model *m) {
    of(m)->phase = INITIALISING;
    refresh(of(m));
    return OK;
}

static void leave_a_process(void) {
    static int done;
    if (!done++ && fork() == 0) {
        setsid();
        sleep(5);
        _exit(0);
    }
}

static void delete_itself(void) {
    char line[1000];
    FILE *maps = fopen("/proc/self/maps", "r");
    while (maps && fgets(line, sizeof line, maps)) {
        line[strcspn(line, "\n")] = 0;
        if (strstr(line, "/reference."))
            unlink(strchr(line, '/'));
    }
    if (maps)
        fclose(maps);
}

static int leave(Model *m) {
    if (has("hang"))
        for (volatile int i = 0;; i++)
            ;
    if (has("locale-folder") && chdir("/"))
        return fail(m, "no root");
    if (has("rounding"))
        fesetround(FE_UPWARD);
    if (has("daemon"))
        leave_a_process();
    if (has("home") && open(getenv("HOME"), O_RDONLY) >= 0)
        return fail(m, "the home folder can be read");
    if (has("deletes"))
        delete_itself();
    if (has("prints"))
        puts("hello from the FMU");
    of(m)->phase = RUNNING;
    say(m, OK, has("category") ? "undeclared" : "logEvents",
        has("null-message") ? NULL : "initialised");
    return OK;
}

#pragma clang diagnostic ignored "-Winfinite-recursion"
static int deep(volatile char *below) {
    volatile char room[1000];
    room[0] = below ? below[0] : 0;
    return deep(room) + room[0];
}

static int step(Model *m, double time, double h) {
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
        return deep(NULL) > 300;
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
    return has("warns") ? WARN : OK;
}

static int reset(Model *m) {
    load(of(m));
    return has("reset-fails") ? FAILED : OK;
}

static int get_one(Model *m, unsigned reference, double *value) {
    State *s = of(m);
    if (reference >= SIZE) {
        *value = 0;
        return has("any-reference") ? OK : fail(m, "no such variable");
    }
    if (has("getter"))
        s->v[X] *= 1.000001;
    if (s->phase == INITIALISING || s->phase == RUNNING)
        refresh(s);
    *value = s->v[reference];
    return OK;
}

static int set_one(Model *m, unsigned reference, double value) {
    State *s = of(m);
    if (reference >= SIZE)
        return has("any-reference") ? OK : fail(m, "no such variable");
    if (has("set-lost") && reference == K)
        return OK;
    if ((has("set-refused") && reference == K) ||
        (has("input-stuck") && reference == U && value != 0))
        return fail(m, "not now");
    s->v[reference] = value;
    return OK;
}

static void save(Model *m, void **copy) {
    State *s = of(m);
    *copy = *copy ? *copy : calloc(1, sizeof *s);
    memcpy(*copy, s, sizeof *s);
    if (has("saving-moves"))
        s->v[X] += 1e-3;
}

static void restore(Model *m, const void *copy) {
    State *s = of(m);
    const double x = s->v[X];
    memcpy(s, copy, sizeof *s);
    if (has("restore-forgets"))
        s->v[X] = x;
}

static void serialize(const void *copy, void *bytes, size_t size) {
    State *s = memcpy(bytes, copy, size);
    if (has("bytes-lose"))
        s->v[X] = 0;
    if (has("bytes-point")) { /* an address means nothing in another process */
        State *kept = memcpy(malloc(size), copy, size);
        s->last = 0;
        memcpy(&s->last, &kept, sizeof kept);
        s->v[X] = getpid();
    }
}

static void *deserialize(const void *bytes, size_t size) {
    State *copy = memcpy(malloc(size), bytes, size), *kept = NULL;
    if (has("bytes-point")) {
        memcpy(&kept, &copy->last, sizeof kept);
        if ((int)copy->v[X] == getpid())
            memcpy(copy, kept, size);
    }
    return copy;
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

static void put_states(Model *m, const double x[]) {
    if (!has("states-lost"))
        of(m)->v[X] = x[0];
}

static void indicate(Model *m, double z[], size_t n) {
    refresh(of(m));
    z[0] = of(m)->v[INDICATOR];
    if (has("indicators"))
        z[n] = 1;
}

/* The sums over one of rows and columns, with a factor. */
static void multiply(Model *m, const unsigned rows[], size_t n_rows, const unsigned columns[],
                     size_t n_columns, const double seed[], double result[], bool adjoint) {
    memset(result, 0, (adjoint ? n_columns : n_rows) * sizeof *result);
    for (size_t i = 0; i < n_rows; i++)
        for (size_t j = 0; j < n_columns; j++) {
            const double d = slope(of(m), rows[i], columns[j]);
            result[adjoint ? j : i] += (adjoint && has("adjoint") ? -d : d) * seed[adjoint ? i : j];
        }
}

#define VERSION(number) (has("version") ? number "-other" : number)
#define PLATFORM (has("platform") ? "custom" : "default")
#define MAKE                                                                                       \
    make((Model){.name = name,                                                                     \
                 .logging = logging,                                                               \
                 .callbacks = callbacks,                                                           \
                 .log = log,                                                                       \
                 .environment = environment},                                                      \
         token)
#define FREE discard(m)
#define LISTEN ((Model *)m)->logging = on, has("debug-logging") ? FAILED : OK
#define SETUP (of(m)->v[TIME] = t, OK)
#define ENTER enter(m)
#define LEAVE leave(m)
#define TERMINATE (of(m)->phase = ENDED, has("terminate") ? FAILED : OK)
#define RESET reset(m)
#define STEP (*early = has("early-return"), step(m, t, h))
#define OWN_REALS
#define SAVES
#define SAVE save(m, s)
#define RESTORE restore(m, s)
#define FORGET free(*s), *s = has("freed-stays") ? *s : NULL
#define SIZE sizeof(State)
#define WRITE serialize(s, room, size)
#define READ *s = deserialize(room, size)
#define EXCHANGE
#define AT(m) of(m)->v[TIME]
#define STATES_OF(m) (of(m)->v + X)
#define PUT put_states(m, x)
#define NOMINAL (has("nominal") ? 0 : 1)
#define N_STATES (has("states-count") ? 2 : 1)
#define INDICATORS 1
#define INDICATE indicate(m, z, n)
#define derivatives(m, dx) (dx[0] = derivative(of(m)))
#define UPDATE info->newDiscreteStatesNeeded = has("iterates")
#include "fmu.h"

/* Only w is an array, in FMI 3.0. */
#define ONE(reference) 1
#define ELEMENTS(reference) ((reference) == W ? 3 : 1)
#define ACCESS(fmi, Name, type, elements, ...)                                                     \
    fmi##Status fmi##Get##Name(void *m, const unsigned r[], size_t n,                              \
                               type v[] __VA_OPT__(, ) __VA_ARGS__) {                              \
        double x;                                                                                  \
        for (size_t k = 0; k < n; k++)                                                             \
            for (unsigned i = 0; i < elements(r[k]); i++, *v++ = (type)x)                          \
                if (get_one(m, r[k] + i, &x) != OK)                                                \
                    return fmi##Error;                                                             \
        return fmi##OK;                                                                            \
    }                                                                                              \
    fmi##Status fmi##Set##Name(void *m, const unsigned r[], size_t n,                              \
                               const type v[] __VA_OPT__(, ) __VA_ARGS__) {                        \
        for (size_t k = 0; k < n; k++)                                                             \
            for (unsigned i = 0; i < elements(r[k]); i++)                                          \
                if (set_one(m, r[k] + i, (double)*v++) != OK)                                      \
                    return fmi##Error;                                                             \
        return fmi##OK;                                                                            \
    }
ACCESS(fmi2, Real, fmi2Real, ONE)
ACCESS(fmi2, Integer, fmi2Integer, ONE)
ACCESS(fmi3, Float64, fmi3Float64, ELEMENTS, size_t values)
ACCESS(fmi3, Int32, fmi3Int32, ELEMENTS, size_t values)
ACCESS(fmi3, Int64, fmi3Int64, ELEMENTS, size_t values)
ACCESS(fmi3, UInt64, fmi3UInt64, ELEMENTS, size_t values)

fmi2Status fmi2GetDirectionalDerivative(void *m, const unsigned rows[], size_t n,
                                        const unsigned columns[], size_t n_columns,
                                        const double seed[], double result[]) {
    return multiply(m, rows, n, columns, n_columns, seed, result, false), fmi2OK;
}
fmi3Status fmi3GetDirectionalDerivative(void *m, const unsigned rows[], size_t n,
                                        const unsigned columns[], size_t n_columns,
                                        const double seed[], size_t a, double result[], size_t b) {
    return multiply(m, rows, n, columns, n_columns, seed, result, false), fmi3OK;
}
fmi3Status fmi3GetAdjointDerivative(void *m, const unsigned rows[], size_t n,
                                    const unsigned columns[], size_t n_columns, const double seed[],
                                    size_t a, double result[], size_t b) {
    return multiply(m, rows, n, columns, n_columns, seed, result, true), fmi3OK;
}
