/* Stationary Kalman filter of a servo axis, for models whose memory and parameters carry the names
 * x, v, d, N_last, F_known, F_next and T_s, m, b, tau_i, F_0, L_x, L_v, L_d. */
#ifndef AXIS_FILTER_H
#define AXIS_FILTER_H

#include "numerics/net_force.h"

/* What a sample period does to the axis m dv/dt + b v = N(t), for N going from N_0 to N_1 as a
 * current loop lets it: N(t) = N_h + (N_0 - N_h) e^(-t / tau_i). */
typedef struct Period {
    double keep;     /* the share of N_0 in N_1   [1] */
    double v_v, x_v; /* velocity [1] and way [s] of a velocity */
    double v_h, x_h; /* velocity [s/kg] and way [s2/kg] of a force that is held */
    double v_e, x_e; /* the same of a force that decays with tau_i */
} Period;

static inline Period period_of(const Parameters *p) {
    const double T = p->T_s, y = p->b / p->m * T;
    Period a = {.keep = force_kept(p), .v_v = elementary_exp(-y)};
    a.x_v = T * elementary_phi(y);
    a.v_h = a.x_v / p->m;
    a.x_h = T * T / p->m * elementary_phi2(y);
    if (p->tau_i > 0.0) {
        const double q = T / p->tau_i, least = y < q ? y : q;
        a.v_e = T / p->m * elementary_exp(-least) * elementary_phi(y + q - 2.0 * least);
        a.x_e = p->tau_i * (a.v_h - a.v_e);
    }
    return a;
}

/* One sample: predict from the forces of the period that ends, correct by the encoder. F_ff is what
 * is commanded against known friction for the period that begins. Returns the unexpected way [m].
 */
static inline double axis_sample(Memory *w, double x_enc, double F_m, double F_ff,
                                 const Parameters *p) {
    const Period a = period_of(p);
    const NetForce N = net_force(w, F_m, F_ff, a.keep, p);
    const double force = N.held + w->d;
    const double x = w->x + a.x_v * w->v + a.x_h * force + a.x_e * N.decaying; /* [m] */
    const double v = a.v_v * w->v + a.v_h * force + a.v_e * N.decaying;        /* [m/s] */
    const double r = x_enc - x;                                                /* [m] */
    w->x = x + p->L_x * r;
    w->v = v + p->L_v * r;
    w->d += p->L_d * r;
    return r;
}

#endif
