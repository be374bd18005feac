/* Steps led by the table of components, with what a scenario does to their outputs. */
#ifndef COSIM_DISTURBED_H
#define COSIM_DISTURBED_H

#include "disturbance.h"
#include "walk.h"

/* For both couplings: where all inputs are from row now, the order is free. */
static inline bool step_disturbed(Run *run, const double *now, double *next) {
    const Component *end = run->components + run->n_components;
    for (const Component *c = run->components; c != end; c++) {
        TRY(set_inputs(run, c, now) && do_step(run, c, c->version) &&
            get_outputs(run, c, c->n_outputs, next));
        if (run->within) {
            disturb_within(c, next, run->done);
        } else {
            disturb(run, c, next, run->done + 1);
        }
    }
    return true;
}

__attribute__((noinline)) static bool walk_disturbed(Run *run, int64_t end) {
    return walk(run, end, step_disturbed, add_squares, run->width, run->constant_step);
}

#endif
