/* The force on an axis that its change of momentum does not show, for models with the variables of
 * momentum.toml. */
#ifndef MOMENTUM_H
#define MOMENTUM_H

#include "numerics/net_force.h"

/* Net force less friction is the change of momentum. Differences of the encoder position are mean
 * velocities; from one to the next, the force counts with the weight t / T_s in the period before
 * and 1 - t / T_s in the one that ends. F_ff is commanded against known friction for the period
 * that begins. Returns the friction beyond what is known [N], and the velocity *v [m/s]. */
static inline double unexplained(Memory *w, double x_enc, double F_m, double F_ff, double *v,
                                 const Parameters *p) {
    const NetForce force = net_force(w, F_m, F_ff, force_kept(p), p);
    const double q = p->tau_i > 0.0 ? p->T_s / p->tau_i : 0.0;
    const double falling = q > 0.0 ? elementary_phi2(q) : 0.0;
    const double rising = q > 0.0 ? elementary_phi(q) - falling : 0.0;
    const double mean = w->N_before + 0.5 * force.held + falling * force.decaying; /* [N] */
    w->N_before = 0.5 * force.held + rising * force.decaying;

    const double weight = p->tau_f > 0.0 ? 1.0 - elementary_exp(-p->T_s / p->tau_f) : 1.0;
    const double change = weight * ((x_enc - w->x_last) / p->T_s - w->v); /* [m/s] */
    *v = w->v + 0.5 * change;
    w->x_last = x_enc;
    w->v += change;
    w->N += weight * (mean - w->N);
    return w->N - p->b * *v - p->m * change / p->T_s;
}

#endif
