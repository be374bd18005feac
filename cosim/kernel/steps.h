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

APART bool walk_one_by_one(Run *run, int64_t end) { return walk(run, end, step_one_by_one); }
APART bool walk_in_groups(Run *run, int64_t end) { return walk(run, end, step_in_groups); }

static bool step_until(Run *run, int64_t end) {
    return run->jacobi ? walk_in_groups(run, end) : walk_one_by_one(run, end);
}

#endif
