#include "model.h"

#include "numerics/elementary.h"
#include "numerics/sampling.h"

/* What a sample period does to the axis m dv/dt + b v = N(t), for N going from N_0 to N_1 as a
 * current loop lets it: N(t) = N_h + (N_0 - N_h) e^(-t / tau_i). */
typedef struct Period {
    double keep;     /* e^(-T_s / tau_i), the share of N_0 in N_1   [1] */
    double v_v, x_v; /* velocity [1] and way [s] of a velocity */
    double v_h, x_h; /* velocity [s/kg] and way [s2/kg] of a force that is held */
    double v_e, x_e; /* the same of a force that decays with tau_i */
} Period;

static Period period_of(const Parameters *p) {
    const double T = p->T_s, y = p->b / p->m * T;
    Period a = {.v_v = elementary_exp(-y)};
    a.x_v = T * elementary_phi(y);
    a.v_h = a.x_v / p->m;
    a.x_h = T * T / p->m * elementary_phi2(y);
    if (p->tau_i > 0.0) {
        const double q = T / p->tau_i, least = y < q ? y : q;
        a.keep = elementary_exp(-q);
        a.v_e = T / p->m * elementary_exp(-least) * elementary_phi(y + q - 2.0 * least);
        a.x_e = p->tau_i * (a.v_h - a.v_e);
    }
    return a;
}

/* One sample: predict from the forces of the period that ends, correct by the encoder. */
static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    const Period a = period_of(p);
    /* What is left of the motor force when the known friction has taken its part   [N] */
    w->F_known = w->F_next + (w->F_known - w->F_next) * a.keep;
    w->F_next = u->F_ff;
    const double N = u->F_m - w->F_known;
    const double held = (N - w->N_last * a.keep) / (1.0 - a.keep), decaying = w->N_last - held;
    w->N_last = N;

    const double force = held + w->d;
    const double x = w->x + a.x_v * w->v + a.x_h * force + a.x_e * decaying; /* [m] */
    const double v = a.v_v * w->v + a.v_h * force + a.v_e * decaying;        /* [m/s] */
    const double r = u->x_enc - x;                                           /* [m] */
    w->x = x + p->L_x * r;
    w->v = v + p->L_v * r;
    w->d += p->L_d * r;
}

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .x = u->x_enc, .N_last = u->F_m};
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    if (!samples_countable(w->k, p->T_s, t + h))
        return false;
    for (; sample_due(w->k, p->T_s, t + h); w->k += 1.0)
        sample(w, u, p);
    const double all = w->x + w->v + w->d + w->N_last + w->F_known;
    return all - all == 0.0; /* finite */
}

double model_sample(double t, Memory *w, const Inputs *u, const Parameters *p) {
    for (; samples_countable(w->k, p->T_s, t) && sample_reached(w->k, p->T_s, t); w->k += 1.0)
        sample(w, u, p);
    return w->k * p->T_s;
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->v_hat = w->v;
    y->d_hat = w->d;
}
