/* Scenarios: signals that are replaced, noisy or stuck, as the receivers see them. */
#ifndef COSIM_DISTURBANCE_H
#define COSIM_DISTURBANCE_H

#include "kernel.h"

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

#endif
