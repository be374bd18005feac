/* One step of all components: inputs from row now and, where fresh, from row next; outputs to next.
 * In place of this file, cosim/kernel/unrolled.py writes one for a certain system. */
#ifndef COSIM_STEPS_H
#define COSIM_STEPS_H

#include "calls.h"

enum { GROUP = 32 };

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

INLINE bool step_one_by_one(Run *run, const double *now, double *next, double t, double h) {
    const Component *end = run->components + run->n_components;
    ALL_IN_TURN(c, run->components, end,
                set_inputs(run, c, now) && do_step(run, c, c->version, t, h) &&
                    get_outputs(run, c, c->n_outputs, next));
    return true;
}

/* With all inputs from this point in time the order is free. A group's calls overlap in the
 * processor, and its memory stays in the nearest cache from one call to the next. */
INLINE bool step_in_groups(Run *run, const double *now, double *next, double t, double h) {
    const Component *last = run->components + run->n_components;
    for (const Component *begin = run->components; begin != last;) {
        const Component *end = last - begin > GROUP ? begin + GROUP : last;
        ALL_IN_TURN(c, begin, end, set_inputs(run, c, now));
        ALL_IN_TURN(c, begin, end, do_step(run, c, c->version, t, h));
        ALL_IN_TURN(c, begin, end, get_outputs(run, c, c->n_outputs, next));
        begin = end;
    }
    return true;
}

INLINE bool step_components(Run *run, const double *now, double *next, double t, double h) {
    return run->jacobi ? step_in_groups(run, now, next, t, h)
                       : step_one_by_one(run, now, next, t, h);
}

#endif
