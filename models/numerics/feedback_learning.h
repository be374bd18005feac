/* Learning from feedback: what the controller commands and the nominal loop does not explain is the
 * error of the compensator. For models with the variables of feedback_learning.toml. */
#ifndef FEEDBACK_LEARNING_H
#define FEEDBACK_LEARNING_H

#include "numerics/elementary.h"
#include "variables.h"

/* Samples that a regressor can be delayed by, and one more */
enum { DELAYS = 17 };

/* Place of the regressor of D samples ago in a ring whose newest is at w->at. */
static inline int delayed(const Memory *w, const Parameters *p) {
    const int place = (int)w->at - (int)p->D;
    return place < 0 ? place + DELAYS : place;
}

/* Begin a sample. *error [N] is the force of the period that ends that neither this compensator nor
 * the motion v_r explains. Returns the mean of v_r over the period that begins, `lead` ahead. */
static inline double begin_sample(Memory *w, const Inputs *u, const Parameters *p, double *error) {
    *error = u->u - w->F_held - w->u_r;
    const double slope = (u->v_r - w->v_last) / p->T_s; /* [m/s2] */
    const double mean = 0.5 * (w->v_last + u->v_r);     /* [m/s] */
    w->v_last = u->v_r;
    w->u_r = p->m * slope + p->b * mean;
    w->at = (int)w->at + 1 < DELAYS ? w->at + 1.0 : 0.0;
    return mean + p->lead * slope;
}

#endif
