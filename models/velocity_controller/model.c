#include "model.h"

#include "numerics/elementary.h"
#include "numerics/sampling.h"

static double limited(double force, double limit) {
    return force > limit ? limit : force < -limit ? -limit : force;
}

/* One sample: estimate, PI with feedforward, limit. */
static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    /* v+ = v + (1 - e^(-T_s / tau_f)) (dx / T_s - v)   [m/s] */
    const double weight = p->tau_f > 0.0 ? 1.0 - elementary_exp(-p->T_s / p->tau_f) : 1.0;
    w->v_filtered += weight * ((u->x_enc - w->x_last) / p->T_s - w->v_filtered);
    w->x_last = u->x_enc;

    /* u = K_p e + I + F_ff + m_ff a_cmd   [N] */
    const double e = u->v_cmd - w->v_filtered;
    const double feedforward = u->F_ff + p->m_ff * u->a_cmd;
    const double integral = w->I + p->T_s * p->K_i * e;
    const double demanded = p->K_p * e + integral + feedforward;
    w->u_held = limited(demanded, p->u_max);

    /* Anti-windup: the integral stands still while it would push further past the limit. */
    if (demanded == w->u_held || (demanded > 0.0) != (e > 0.0))
        w->I = integral;
}

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .x_last = u->x_enc};
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    for (; sample_due(w->k, p->T_s, t + h); w->k += 1.0)
        sample(w, u, p);
    const double all = w->u_held + w->v_filtered + w->I;
    return all - all == 0.0; /* finite */
}

double model_sample(double t, Memory *w, const Inputs *u, const Parameters *p) {
    for (; sample_reached(w->k, p->T_s, t); w->k += 1.0)
        sample(w, u, p);
    return w->k * p->T_s;
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->u = w->u_held;
    y->v_est = w->v_filtered;
}
