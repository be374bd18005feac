/* Scenarios: signals that are replaced, noisy or stuck, as the receivers see them. */
#ifndef COSIM_DISTURBANCE_H
#define COSIM_DISTURBANCE_H

#include "kernel.h"

static inline double disturbed(double value, double before, double keep, double add) {
    return keep != keep ? before : (keep != 0 ? keep * value : 0) + add;
}

/* Change the outputs of a component in the row of step n. */
static inline void disturb(const Run *run, const Component *c, double *row, int64_t n) {
    for (size_t i = 0; run->disturbed && i < c->n_disturbances; i++) {
        const Disturbance *d = &c->disturbances[i];
        double *value = row + d->column;
        *value = disturbed(*value, value[n > 0 ? -run->width : 0], d->keep[n], d->add[n]);
    }
}

#endif
