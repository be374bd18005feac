#include "numerics/net_force.h"

/* Net force less friction is the change of momentum. Differences of the encoder position are mean
 * velocities; from one to the next, the force counts with the weight t / T_s in the period before
 * and 1 - t / T_s in the one that ends. */
static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    const NetForce force = net_force(w, u->F_m, u->F_in, force_kept(p));
    const double q = p->tau_i > 0.0 ? p->T_s / p->tau_i : 0.0;
    const double falling = q > 0.0 ? elementary_phi2(q) : 0.0;
    const double rising = q > 0.0 ? elementary_phi(q) - falling : 0.0;
    const double mean = w->N_before + 0.5 * force.held + falling * force.decaying; /* [N] */
    w->N_before = 0.5 * force.held + rising * force.decaying;

    const double weight = p->tau_f > 0.0 ? 1.0 - elementary_exp(-p->T_s / p->tau_f) : 1.0;
    const double change = weight * ((u->x_enc - w->x_last) / p->T_s - w->v); /* [m/s] */
    const double v = w->v + 0.5 * change;
    w->x_last = u->x_enc;
    w->v += change;
    w->N += weight * (mean - w->N);
    const double friction = w->N - p->b * v - p->m * change / p->T_s; /* [N] */

    double s = 1.0, rate = p->w_q;
    if (p->coulomb != 0.0) {
        const double speed = (v < 0.0 ? -v : v) / p->v_t; /* [1] */
        s = clipped(v / p->v_t);
        if (p->mu != 1.0)
            rate *= speed > 1e-300 ? elementary_exp((p->mu - 1.0) * elementary_log(speed)) : 0.0;
    }
    w->a += (1.0 - elementary_exp(-rate * p->T_s)) * s * (friction - w->a * s);

    const double slope = (u->v_r - w->v_last) / p->T_s; /* [m/s2] */
    const double early = 0.5 * (w->v_last + u->v_r) + p->lead * slope;
    w->v_last = u->v_r;
    const double direction = clipped((p->measured != 0.0 ? w->v : early) / p->v_t);
    w->F_held = u->F_in + p->share * w->a * (p->coulomb != 0.0 ? direction : 1.0);
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s),
                  .x_last = u->x_enc,
                  .N_last = u->F_m,
                  .N_before = 0.5 * u->F_m,
                  .N = u->F_m,
                  .a = p->a_0,
                  .v_last = u->v_r};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
    y->a_hat = w->a;
}
