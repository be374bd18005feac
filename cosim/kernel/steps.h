/* Steps components one after the other, led by the table of components. In place of this file,
 * unrolled.py writes one for a certain system. */
#ifndef COSIM_STEPS_H
#define COSIM_STEPS_H

#include "walk.h"

enum { GROUP = 12 };

/* Written out four times, each with a call instruction of its own: where components share one, the
 * processor keeps guessing wrong which FMU it leads to, and a step costs up to twice as much. */
#define NEXT(c, end, action)                                                                       \
    TRY(action);                                                                                   \
    if (++c == end) {                                                                              \
        break;                                                                                     \
    }
#define ALL_IN_TURN(c, begin, end, action)                                                         \
    for (const Component *c = begin; c != end;) {                                                  \
        NEXT(c, end, action);                                                                      \
        NEXT(c, end, action);                                                                      \
        NEXT(c, end, action);                                                                      \
        NEXT(c, end, action);                                                                      \
    }

/* Within one function the compiler lets calls share an instruction again, so each is kept apart. */
#define APART __attribute__((noinline)) static

APART bool step_one_by_one(Run *run, const double *now, double *next) {
    const Component *end = run->components + run->n_components;
    ALL_IN_TURN(c, run->components, end,
                set_inputs(run, c, now) && do_step(run, c, c->version) &&
                    get_outputs(run, c, c->n_outputs, next));
    return true;
}

/* With all inputs from this point in time the order is free. A group's calls overlap in the
 * processor, and its memory stays in the nearest cache from one call to the next. Twelve lets rings
 * of two, three, four or six models meet the same call instructions in each group. */
INLINE bool step_in_groups(Run *run, const double *now, double *next) {
    const Component *last = run->components + run->n_components;
    for (const Component *begin = run->components; begin != last;) {
        const Component *end = last - begin > GROUP ? begin + GROUP : last;
        ALL_IN_TURN(c, begin, end, set_inputs(run, c, now));
        ALL_IN_TURN(c, begin, end, do_step(run, c, c->version));
        ALL_IN_TURN(c, begin, end, get_outputs(run, c, c->n_outputs, next));
        begin = end;
    }
    return true;
}

APART bool walk_one_by_one(Run *run, int64_t end) {
    return walk(run, end, step_one_by_one, add_squares, run->width, run->constant_step);
}
APART bool walk_in_groups(Run *run, int64_t end) {
    return walk(run, end, step_in_groups, add_squares, run->width, run->constant_step);
}

/* A few components of one version, all with inputs and outputs: straight code, where the compiler
 * knows number and version. */
INLINE bool step_in_turn(Run *run, const double *now, double *next, int n, int version) {
    const Component *c = run->components;
#pragma clang loop unroll(full)
    for (int i = 0; i < n; i++, c++) {
        TRY(set_some_inputs(run, c, version, now) && do_step(run, c, version) &&
            get_some_outputs(run, c, version, c->n_outputs, next));
    }
    return true;
}

INLINE bool step_at_once(Run *run, const double *now, double *next, int n, int version) {
    const Component *c = run->components;
#pragma clang loop unroll(full)
    for (int i = 0; i < n; i++) {
        TRY(set_some_inputs(run, c + i, version, now));
    }
#pragma clang loop unroll(full)
    for (int i = 0; i < n; i++) {
        TRY(do_step(run, c + i, version));
    }
#pragma clang loop unroll(full)
    for (int i = 0; i < n; i++) {
        TRY(get_some_outputs(run, c + i, version, c[i].n_outputs, next));
    }
    return true;
}

#define FEW(X) X(1) X(2) X(3) X(4) X(5) X(6)
#define STRAIGHT(how, n, version)                                                                  \
    INLINE bool how##_##n##_##version(Run *run, const double *now, double *next) {                 \
        return how(run, now, next, n, version);                                                    \
    }                                                                                              \
    APART bool walk_##how##_##n##_##version(Run *run, int64_t end) {                               \
        return walk(run, end, how##_##n##_##version, add_squares, run->width, run->constant_step); \
    }
#define EACH_STRAIGHT(n)                                                                           \
    STRAIGHT(step_in_turn, n, 2)                                                                   \
    STRAIGHT(step_in_turn, n, 3) STRAIGHT(step_at_once, n, 2) STRAIGHT(step_at_once, n, 3)
#define ENTRY(n)                                                                                   \
    [n] = {{walk_step_in_turn_##n##_2, walk_step_in_turn_##n##_3},                                 \
           {walk_step_at_once_##n##_2, walk_step_at_once_##n##_3}},

FEW(EACH_STRAIGHT)

/* NULL where these components need the loops above. */
static bool (*find_straight(const Run *run))(Run *run, int64_t end) {
    static bool (*const walks[][2][2])(Run *run, int64_t end) = {FEW(ENTRY)};
    const int64_t n = run->n_components;
    const int32_t version = n ? run->components->version : 0;
    if (n == 0 || n >= (int64_t)(sizeof walks / sizeof *walks)) {
        return NULL;
    }
    for (const Component *c = run->components; c != run->components + n; c++) {
        if (c->version != version || c->inputs == NONE || c->n_outputs == 0) {
            return NULL;
        }
    }
    return walks[n][run->jacobi != 0][version == 3];
}

static bool step_until(Run *run, int64_t end) {
    bool (*straight)(Run *, int64_t) = find_straight(run);
    return straight      ? straight(run, end)
           : run->jacobi ? walk_in_groups(run, end)
                         : walk_one_by_one(run, end);
}

#endif
