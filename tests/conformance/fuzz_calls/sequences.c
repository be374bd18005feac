/* Random sequences of FMI calls, lawful and not, on several instances of one model at a time.
 *
 * Each instance has a shadow that is given the lawful calls only. An unlawful call must answer
 * error, and leave no trace: all variables of the two agree, bit for bit, after each of them. What
 * is lawful is told by the tables here: the life cycle as the standards draw it, and the variables
 * as model.toml has them.
 *
 *     sequences FIRST COUNT    prints "CALLS UNLAWFUL HASH"
 */
#include "calls.h"
#include "instance.h" /* the table of variables; no function of it is called */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>

#if FMI == 2
#define FREE(c) fmi2FreeInstance(c)
#else
#define FREE(c) fmi3FreeInstance(c)
#endif

enum { PAIRS = 3, KEPT = 3, MOST = 4 };
enum { CREATED = 1, STARTING = 2, STEPS = 4, OVER = 8, FAULTY = 16, EVENTS = 32, FLOWING = 64 };
enum { WELL = CREATED | STARTING | STEPS | OVER | EVENTS | FLOWING, ALWAYS = WELL | FAULTY };

enum { FUZZED, SHADOW };

typedef struct {
    State of[2];
    int phase;
} Kept;

typedef struct {
    Slave at[2];
    bool exchange;
    int phase;
    double t;
    Kept kept[KEPT];
    State freed;
} Pair;

static Pair pairs[PAIRS];
static uint64_t seed, state, calls, unlawful, hash = 0xCBF29CE484222325u;
static const char *doing = "";

static uint64_t draw(void) { /* SplitMix64 */
    uint64_t x = state += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

static unsigned below(unsigned n) { return (unsigned)(draw() % n); }
static bool rarely(void) { return below(6) == 0; }

static void violated(const char *what, int got) {
    fprintf(stderr, "sequence %llu: %s: %s (%d)\n", (unsigned long long)seed, doing, what, got);
    _Exit(3);
}

static void hangs(int signal) {
    (void)signal;
    violated("does not end", 0);
}

static void mix(const void *bytes, size_t size) {
    for (size_t k = 0; k < size; k++)
        hash = (hash ^ ((const uint8_t *)bytes)[k]) * 0x100000001B3u;
}

static int get_any(Slave c, uint32_t k, double *value) {
    int32_t whole = 0;
    Truth truth = 0;
    int status;
    switch (VARIABLES[k].type) {
    case INTEGER:
        status = ACCESS(Get, Integer, Int32, c, &k, 1, &whole, 1);
        *value = whole;
        return status;
    case BOOLEAN:
        status = ACCESS(Get, Boolean, Boolean, c, &k, 1, &truth, 1);
        *value = truth;
        return status;
    default:
        return ACCESS(Get, Real, Float64, c, &k, 1, value, 1);
    }
}

static void compare(const Pair *p) {
    for (uint32_t k = 0; k < COUNT; k++) {
        double a = 0.0, b = 0.0;
        if (get_any(p->at[FUZZED], k, &a) || get_any(p->at[SHADOW], k, &b))
            violated("a variable cannot be read", (int)k);
        if (memcmp(&a, &b, sizeof a) != 0)
            violated("left a trace in variable", (int)k);
        mix(&a, sizeof a);
    }
}

/* Whether the shadow is to be called as well. */
static bool check_call(const Pair *p, int status, bool lawful) {
    calls++;
    mix(&status, sizeof status);
    if (lawful)
        return true;
    unlawful++;
    if (status != ERROR)
        violated("unlawful, but not an error", status);
    compare(p);
    return false;
}

static void agree(int status, int of_shadow) {
    if (status != of_shadow)
        violated("another status than the shadow's", of_shadow);
}

/* Calls `c`, which is one and then the other; `who` tells which. */
#define BOTH(p, lawful, call)                                                                      \
    do {                                                                                           \
        int who = FUZZED;                                                                          \
        Slave c = p->at[who];                                                                      \
        status = call;                                                                             \
        if (check_call(p, status, lawful)) {                                                       \
            who = SHADOW, c = p->at[who];                                                          \
            agree(status, call);                                                                   \
        }                                                                                          \
        (void)who;                                                                                 \
    } while (0)
/* A call that only leads from some phases to another. */
#define CHANGE(p, from, name, to)                                                                  \
    do {                                                                                           \
        doing = #name;                                                                             \
        BOTH(p, ((p)->phase & (from)) != 0, CALL(name, c));                                        \
        (p)->phase = status == OK ? (to) : (p)->phase;                                             \
    } while (0)
#define MUST(condition)                                                                            \
    if (!(condition))                                                                              \
    violated("must be: " #condition, status)

static double odd_number(void) {
    static const double numbers[] = {NAN,  INFINITY, -INFINITY, 1e300, -1e300, 5e-324,
                                     -0.0, 1.0,      1e18,      -1.0,  1e-3,   0.5};
    return numbers[below(sizeof numbers / sizeof *numbers)];
}

/* Life cycle */

static void make(Pair *p) {
    const bool wants_exchange = below(2), has_exchange = IS_CONTINUOUS || IS_SAMPLED;
    doing = "instantiate";
    if (instantiate("x", rarely() ? NULL : "stale", wants_exchange, below(2)))
        violated("took a wrong token", 0);
    *p = (Pair){.exchange = wants_exchange && has_exchange, .phase = CREATED};
    p->at[FUZZED] = instantiate(below(2) ? "fuzzed" : NULL, START.token, p->exchange, below(2));
    p->at[SHADOW] = instantiate("shadow", START.token, p->exchange, false);
    if (!p->at[FUZZED] || !p->at[SHADOW])
        violated("no instance", 0);
}

static void end(Pair *p) { /* states that were not freed go with it */
    doing = "free";
    FREE(p->at[FUZZED]);
    FREE(p->at[SHADOW]);
    make(p);
}

static void live(Pair *p) {
    const double start = rarely() ? odd_number() : below(3) * 0.1;
    int status;
    unsigned what = below(7);
    if (below(2) && (p->phase & (CREATED | STARTING))) /* onwards */
        what = p->phase == CREATED ? 0 : 2;
    switch (what) {
    case 0:
    case 1:
#if FMI == 2
        CHANGE(p, CREATED, EnterInitializationMode, STARTING);
#else
        doing = "enter initialization";
        BOTH(p, p->phase == CREATED && isfinite(start), enter_initialization(c, start));
        p->t = status == OK ? start : p->t;
        p->phase = status == OK ? STARTING : p->phase;
#endif
        break;
    case 2:
    case 3:
        CHANGE(p, STARTING, ExitInitializationMode, p->exchange ? EVENTS : STEPS);
        break;
    case 4:
        if (rarely())
            CHANGE(p, STEPS | EVENTS | FLOWING, Terminate, OVER);
        break;
    case 5:
        if (rarely()) {
            CHANGE(p, ALWAYS, Reset, CREATED);
            MUST(status == OK);
        }
        break;
    default:
        doing = "setup";
#if FMI == 2
        const bool lawful = p->phase == CREATED && isfinite(start);
        BOTH(p, lawful, CALL(SetupExperiment, c, 0, 0.0, start, 0, 0.0));
        p->t = status == OK ? start : p->t;
#endif
        break;
    }
}

static void go(Pair *p) {
    static const double steps[] = {5e-4, 1e-3, 1e-4, 3.7e-4, 0.0123};
    const double h = rarely() ? odd_number() : steps[below(5)];
    const double t = rarely() && rarely() ? odd_number() : p->t;
    const bool answers = FMI == 2 || !rarely();
    int status;
    doing = "step";
    const bool lawful = p->phase == STEPS && answers && isfinite(t) && isfinite(h) && h > 0.0;
    BOTH(p, lawful, step(c, t, h, answers));
    if (lawful) {
        MUST(status == OK || status == ERROR);
        p->phase = status == OK ? STEPS : FAULTY;
        p->t = t + h;
        compare(p);
    }
}

/* Values */

static bool fits(const Pair *p, uint32_t k, Type type, bool setting, double value) {
    if (k >= COUNT || (VARIABLES[k].type != type &&
                       !(VARIABLES[k].type == DERIVATIVE && type == REAL && !setting)))
        return false;
    const int may = VARIABLES[k].settable; /* the bits are those of the phases here */
    return !setting ||
           ((may & p->phase) && value >= VARIABLES[k].minimum && value <= VARIABLES[k].maximum);
}

static uint32_t some_variable(Type type) {
    if (rarely() && rarely())
        return below(2) ? COUNT + below(3) : UINT32_MAX - below(2);
    uint32_t k = below(COUNT);
    for (int i = 0; i < COUNT && VARIABLES[k].type != type && !(rarely() && rarely()); i++)
        k = (k + 1) % COUNT;
    return k;
}

static double some_value(uint32_t k) {
    if (rarely() || k >= COUNT)
        return odd_number();
    const double share = below(1001) / 1000.0, start = START.values[k];
    return VARIABLES[k].type == REAL ? start + (share - 0.5) * VARIABLES[k].nominal : below(4);
}

static void transfer(Pair *p, bool setting) {
    const Type type = (Type)below(3);
    uint32_t r[MOST];
    double value[MOST] = {0}, other[MOST] = {0};
    int32_t whole[MOST] = {0};
    Truth truth[MOST] = {0};
    const size_t given = below(MOST + 1);
    size_t n = given;
    bool lawful = (p->phase & (setting ? WELL : ALWAYS)) != 0;
    for (size_t k = 0; k < given; k++) {
        r[k] = some_variable(type);
        value[k] = some_value(r[k]);
        whole[k] = (int32_t)(below(2) ? below(4) : draw());
        truth[k] = below(FMI == 2 ? 3 : 2);
        const double taken = type == REAL      ? value[k]
                             : type == INTEGER ? (double)whole[k]
                                               : (double)truth[k];
        lawful = fits(p, r[k], type, setting, taken) && lawful;
    }
    const uint32_t *references = r;
    void *values = type == REAL ? (void *)value : type == INTEGER ? (void *)whole : (void *)truth;
    if (rarely() && rarely()) { /* nothing, or more than there is: the first is refused */
        n = below(2) ? SIZE_MAX : n + 1;
        lawful = false;
        r[0] = COUNT;
        if (below(2))
            references = NULL;
        else if (below(2))
            values = NULL;
    }
    const size_t n_values = FMI == 2 || !rarely() || !rarely() ? n : n && below(2) ? n - 1 : n + 1;
    lawful = lawful && n_values == n;
    int status = OK;
#define TRANSFER(verb, c, v)                                                                       \
    (type == REAL      ? ACCESS(verb, Real, Float64, c, references, n, v, n_values)                \
     : type == INTEGER ? ACCESS(verb, Integer, Int32, c, references, n, v, n_values)               \
                       : ACCESS(verb, Boolean, Boolean, c, references, n, v, n_values))
    if (setting) {
        doing = "set";
        BOTH(p, lawful, TRANSFER(Set, c, values));
    } else {
        doing = "get";
        BOTH(p, lawful, TRANSFER(Get, c, who ? (void *)other : values));
        if (lawful && memcmp(values, other,
                             n * (type == REAL      ? sizeof *value
                                  : type == INTEGER ? sizeof *whole
                                                    : sizeof *truth)) != 0)
            violated("other values than the shadow's", 0);
    }
    MUST(!lawful || status == OK);
}

static void differentiate(Pair *p) {
    uint32_t of[MOST], by[MOST];
    const double seeds[MOST] = {1.0, -2.0, 0.5, 3.0};
    double a[MOST] = {0}, b[MOST] = {0};
    const size_t n_of = below(MOST + 1), n_by = below(MOST + 1);
    bool lawful = HAS_SLOPES && (p->phase & ~(CREATED | FAULTY)) != 0;
    for (size_t k = 0; k < MOST; k++) {
        of[k] = rarely() ? some_variable(REAL) : STATES_AT + below(OUTPUTS_AT + 1 - STATES_AT);
        by[k] = rarely() ? some_variable(REAL) : INPUTS_AT + below(INPUTS_COUNT + STATES_COUNT);
        const bool unknown =
            (of[k] >= STATES_AT && of[k] < STATES_AT + STATES_COUNT) ||
            (of[k] >= DERIVATIVES_AT && of[k] < DERIVATIVES_AT + DERIVATIVES_COUNT) ||
            (of[k] >= OUTPUTS_AT && of[k] < OUTPUTS_AT + OUTPUTS_COUNT);
        const bool known = (by[k] >= STATES_AT && by[k] < STATES_AT + STATES_COUNT) ||
                           (by[k] >= INPUTS_AT && by[k] < INPUTS_AT + INPUTS_COUNT);
        lawful = lawful && (k >= n_of || unknown) && (k >= n_by || known);
    }
    const bool absent = rarely() && n_of > 0;
    const uint32_t *unknowns = absent ? NULL : of;
    lawful = lawful && !absent;
    int status;
    doing = "differentiate";
#if FMI == 2
#define DIFFERENTIATE(c, to) CALL(GetDirectionalDerivative, c, unknowns, n_of, by, n_by, seeds, to)
#else
    const size_t spare = rarely() ? 1 : 0, n_seeds = n_by + spare;
    lawful = lawful && !spare;
#define DIFFERENTIATE(c, to)                                                                       \
    CALL(GetDirectionalDerivative, c, unknowns, n_of, by, n_by, seeds, n_seeds, to, n_of)
#endif
    BOTH(p, lawful, DIFFERENTIATE(c, who ? b : a));
    MUST(!lawful || (status == OK && memcmp(a, b, sizeof a) == 0));
#if FMI == 3
#define TRANSPOSE(c, to)                                                                           \
    CALL(GetAdjointDerivative, c, unknowns, n_of, by, n_by, seeds, n_of + spare, to, n_by)
    BOTH(p, lawful, TRANSPOSE(c, who ? b : a));
    MUST(!lawful || (status == OK && memcmp(a, b, sizeof a) == 0));
#endif
}

/* States */

static State foreign(const Pair *p) { /* any that is not this instance's */
    const Pair *other = &pairs[below(PAIRS)];
    const State candidates[] = {NULL, p->freed, other->kept[below(KEPT)].of[FUZZED],
                                p->kept[below(KEPT)].of[SHADOW], &pairs};
    const State found = candidates[below(5)];
    for (int k = 0; k < KEPT; k++)
        if (found && found == p->kept[k].of[FUZZED])
            return NULL;
    return found;
}

static void serialize(Pair *p, Kept *kept) {
    static uint8_t bytes[65536], of_shadow[65536];
    size_t size = 0;
    int status;
    doing = "serialized size";
    BOTH(p, kept->of[FUZZED] != NULL,
         EITHER(SerializedFMUstateSize, SerializedFMUStateSize, c, kept->of[who], &size));
    if (!kept->of[FUZZED])
        return;
    MUST(status == OK && size > 0 && size <= sizeof bytes);
    doing = "serialized size of no state";
    const State wrong = foreign(p);
    BOTH(p, false, EITHER(SerializedFMUstateSize, SerializedFMUStateSize, c, wrong, &size));
    doing = "serialize";
    const bool absent = rarely();
    const size_t room = rarely() ? below((unsigned)size) : size;
    BOTH(p, room >= size && !absent,
         EITHER(SerializeFMUstate, SerializeFMUState, c, kept->of[who],
                absent ? NULL
                : who  ? of_shadow
                       : bytes,
                room));
    if (status != OK)
        return;
    doing = "deserialize";
    Pair *to = rarely() ? &pairs[below(PAIRS)] : p;
    const bool spoilt = below(2);
    if (spoilt)
        bytes[below((unsigned)size)] ^= (uint8_t)(1 + below(255));
    const size_t told = rarely() ? (below(2) ? 0 : size - 1) : size;
    Kept found = {{NULL, NULL}, kept->phase};
    const bool lawful = !spoilt && told == size && to->exchange == p->exchange;
    BOTH(to, lawful,
         EITHER(DeSerializeFMUstate, DeserializeFMUState, c, who ? of_shadow : bytes, told,
                &found.of[who]));
    MUST(lawful == (status == OK));
    Kept *place = &to->kept[below(KEPT)];
    if (status == OK && !place->of[FUZZED])
        *place = found; /* else nobody frees it: its instance will */
}

static void remember(Pair *p) {
    Kept *kept = &p->kept[below(KEPT)];
    const State wrong = foreign(p);
    State place = wrong;
    int status;
    switch (below(7)) {
    case 0:
    case 1:
        doing = "save";
        BOTH(p, true, EITHER(GetFMUstate, GetFMUState, c, &kept->of[who]));
        MUST(status == OK && kept->of[FUZZED]);
        kept->phase = p->phase;
        break;
    case 2:
    case 3:
        doing = "restore";
        BOTH(p, kept->of[FUZZED] != NULL, EITHER(SetFMUstate, SetFMUState, c, kept->of[who]));
        MUST(!kept->of[FUZZED] || status == OK);
        p->phase = status == OK ? kept->phase : p->phase;
        compare(p);
        break;
    case 4:
        doing = "free a state";
        if (kept->of[FUZZED]) {
            p->freed = kept->of[FUZZED];
            BOTH(p, true, EITHER(FreeFMUstate, FreeFMUState, c, &kept->of[who]));
            MUST(status == OK && !kept->of[FUZZED]);
        }
        break;
    case 5:
        doing = "a state that is none";
        BOTH(p, false, EITHER(SetFMUstate, SetFMUState, c, wrong));
        BOTH(p, false, EITHER(GetFMUstate, GetFMUState, c, place ? &place : NULL));
        if (place)
            BOTH(p, false, EITHER(FreeFMUstate, FreeFMUState, c, &place));
        break;
    default:
        serialize(p, kept);
    }
}

/* Model Exchange */

static void exchange(Pair *p) {
    const bool flows = p->phase == FLOWING, read = (p->phase & ~(CREATED | FAULTY | STEPS)) != 0;
    double a[COUNT + 1] = {0}, next;
    const size_t n = rarely() ? (below(2) ? SIZE_MAX : DERIVATIVES_COUNT + 1) : DERIVATIVES_COUNT;
    double *place = rarely() ? NULL : a;
    const bool counted = n == DERIVATIVES_COUNT && (n == 0 || place);
    const bool answers = !rarely();
    const double t = rarely() ? odd_number() : p->t + below(3) * 1e-4;
    int status = OK;
    bool lawful = counted;
    switch (below(10)) {
    case 0:
        doing = "update discrete states";
        BOTH(p, p->phase == EVENTS && answers, update(c, answers, &next));
        break;
    case 1:
        CHANGE(p, EVENTS, EnterContinuousTimeMode, FLOWING);
        break;
    case 2:
        CHANGE(p, FLOWING, EnterEventMode, EVENTS);
        break;
    case 3:
        doing = "set time";
        lawful = (p->phase & (EVENTS | FLOWING)) && isfinite(t);
        BOTH(p, lawful, CALL(SetTime, c, t));
        p->t = status == OK ? t : p->t;
        break;
    case 4:
        doing = "completed integrator step";
        BOTH(p, flows && answers, completed(c, answers));
        break;
    case 5:
    case 6:
        doing = "set continuous states";
        lawful = lawful && flows;
        for (size_t k = 0; k < DERIVATIVES_COUNT; k++)
            a[k] = rarely() ? odd_number() : 1e-3 * below(100);
        BOTH(p, lawful, CALL(SetContinuousStates, c, place, n));
        if (status == DISCARD)
            compare(p);
        break;
    case 7:
        doing = "get derivatives";
        lawful = lawful && read;
        BOTH(p, lawful, EITHER(GetDerivatives, GetContinuousStateDerivatives, c, place, n));
        break;
    case 8:
        doing = "get continuous states";
        lawful = lawful && read;
        BOTH(p, lawful, CALL(GetContinuousStates, c, place, n));
        break;
    default:
        doing = "get nominals";
        lawful = lawful && (read || p->phase == CREATED);
        BOTH(p, lawful, CALL(GetNominalsOfContinuousStates, c, place, n));
        const size_t of_events = INDICATORS_COUNT + (rarely() ? 1 : 0);
        doing = "get event indicators";
        BOTH(p, read && of_events == INDICATORS_COUNT, CALL(GetEventIndicators, c, a, of_events));
    }
}

/* The rest */

static void speak(Pair *p) {
    const char *categories[] = {"logEvents", "no such category", NULL};
    const size_t n = below(4);
    int status;
    doing = "set debug logging";
    const char *const *given = rarely() ? NULL : categories;
    const bool on = below(2);
#if FMI == 2
#define LISTEN(c) CALL(SetDebugLogging, c, on, n, (fmi2String *)(uintptr_t)given)
#else
#define LISTEN(c) CALL(SetDebugLogging, c, on, n, given)
#endif
    BOTH(p, n == 0 || (given && n < 3), LISTEN(c));
    doing = "a call on no instance";
    double value = 0.0;
    uint32_t k = below(COUNT);
    status = below(4) == 0   ? CALL(Reset, NULL)
             : below(3) == 0 ? step(NULL, 0.0, 1e-3, true)
             : below(2)      ? ACCESS(Get, Real, Float64, NULL, &k, 1, &value, 1)
                             : EITHER(SetFMUstate, SetFMUState, NULL, p->kept[0].of[FUZZED]);
    check_call(p, status, false);
    doing = "a call that is not declared";
#if FMI == 2
    const fmi2Integer order = 1;
    status = CALL(SetRealInputDerivatives, p->at[FUZZED], &k, 1, &order, &value);
#else
    status = below(2) ? CALL(EnterConfigurationMode, p->at[FUZZED])
                      : CALL(GetShiftDecimal, p->at[FUZZED], NULL, SIZE_MAX, NULL);
#endif
    check_call(p, status, false);
}

static void act(Pair *p) {
    const unsigned what = below(20);
    if (what < 5)
        live(p);
    else if (what < 9)
        p->exchange ? exchange(p) : go(p);
    else if (what < 10)
        p->exchange ? go(p) : exchange(p);
    else if (what < 13)
        transfer(p, true);
    else if (what < 15)
        transfer(p, false);
    else if (what < 18)
        remember(p);
    else if (what < 19)
        below(3) ? differentiate(p) : speak(p);
    else if (rarely())
        end(p);
}

int main(int n, char **words) {
    const uint64_t first = n > 1 ? strtoull(words[1], NULL, 10) : 0;
    const uint64_t count = n > 2 ? strtoull(words[2], NULL, 10) : 1;
    signal(SIGVTALRM, hangs);
    for (seed = first; seed < first + count; seed++) {
        setitimer(ITIMER_VIRTUAL, &(struct itimerval){{0, 0}, {20, 0}}, NULL); /* s, of work */
        state = seed * 0xD1B54A32D192ED03u;
        for (int i = 0; i < PAIRS; i++)
            make(&pairs[i]);
        for (unsigned left = 20 + below(60); left > 0; left--)
            act(&pairs[below(PAIRS)]);
        for (int i = 0; i < PAIRS; i++) {
            compare(&pairs[i]);
            FREE(pairs[i].at[FUZZED]);
            FREE(pairs[i].at[SHADOW]);
        }
    }
    printf("%llu %llu %016llx\n", (unsigned long long)calls, (unsigned long long)unlawful,
           (unsigned long long)hash);
    return 0;
}
