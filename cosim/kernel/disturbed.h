/* Scenarios: signals that are replaced, noisy or stuck, as the receivers see them. */
#ifndef COSIM_DISTURBED_H
#define COSIM_DISTURBED_H

#include "walk.h"

/* Change the outputs of a component in the row of step n. */
static inline void disturb(const Run *run, const Component *c, double *row, int64_t n) {
    for (size_t i = 0; run->disturbed && i < c->n_disturbances; i++) {
        const Disturbance *d = &c->disturbances[i];
        const double keep = d->keep[n];
        double *value = row + d->column;
        if (keep != keep) {
            *value = n > 0 ? value[-run->width] : *value;
        } else {
            *value = (keep != 0 ? keep * *value : 0) + d->add[n];
        }
    }
}

/* For both couplings: where all inputs are from row now, the order is free. */
static inline bool step_disturbed(Run *run, const double *now, double *next) {
    const Component *end = run->components + run->n_components;
    for (const Component *c = run->components; c != end; c++) {
        TRY(set_inputs(run, c, now) && do_step(run, c, c->version) &&
            get_outputs(run, c, c->n_outputs, next));
        disturb(run, c, next, run->done + 1);
    }
    return true;
}

__attribute__((noinline)) static bool walk_disturbed(Run *run, int64_t end) {
    return walk(run, end, step_disturbed);
}

#endif
