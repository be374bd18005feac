/* The net force on an axis over a sample period, for models whose memory and parameters carry the
 * names N_last, F_known, F_next and T_s, tau_i, F_0. */
#ifndef NET_FORCE_H
#define NET_FORCE_H

#include "numerics/elementary.h"
#include "variables.h"

/* N(t) = held + decaying e^(-t / tau_i) [N], as a current loop lets it, from the start of a period
 */
typedef struct NetForce {
    double held, decaying;
} NetForce;

/* e^(-T_s / tau_i), the share of a period's first force in its last [1] */
static inline double force_kept(const Parameters *p) {
    return p->tau_i > 0.0 ? elementary_exp(-p->T_s / p->tau_i) : 0.0;
}

/* Motor force less known friction and F_0 over the period that ends. F_m is the motor force at its
 * end, and F_ff is commanded against known friction for the period that begins. */
static inline NetForce net_force(Memory *w, double F_m, double F_ff, double keep,
                                 const Parameters *p) {
    /* What is left of the motor force when the known friction has taken its part   [N] */
    w->F_known = w->F_next + (w->F_known - w->F_next) * keep;
    w->F_next = F_ff;
    const double N = F_m - p->F_0 - w->F_known;
    const double held = (N - w->N_last * keep) / (1.0 - keep);
    const NetForce force = {held, w->N_last - held};
    w->N_last = N;
    return force;
}

#endif
