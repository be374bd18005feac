/* Scenarios: signals that are replaced, noisy or stuck, as the receivers see them. */
#ifndef COSIM_DISTURBANCE_H
#define COSIM_DISTURBANCE_H

#include "kernel.h"

static inline double disturbed(const Disturbance *d, int64_t n, double value, double add) {
    const double keep = d->keep[n];
    return (keep != keep ? d->held : keep != 0 ? keep * value : 0) + add;
}

/* Change the outputs of a component in the row of step n, and take note of what those hold that
 * stick from the next on. */
static inline void disturb(const Run *run, const Component *c, double *row, int64_t n) {
    for (size_t i = 0; run->disturbed && i < c->n_disturbances; i++) {
        Disturbance *d = &c->disturbances[i];
        double *value = row + d->column;
        d->held = n > 0 ? d->held : *value; /* there is no step before */
        *value = disturbed(d, n, *value, d->add[n]);
        d->held = d->keep[n] == d->keep[n] ? *value : d->held;
    }
}

/* In a part of the step from n that another one follows, a scenario does what it does at n. */
static inline void disturb_within(const Component *c, double *row, int64_t n) {
    for (size_t i = 0; i < c->n_disturbances; i++) {
        const Disturbance *d = &c->disturbances[i];
        row[d->column] = disturbed(d, n, row[d->column], d->add[n]);
    }
}

#endif
