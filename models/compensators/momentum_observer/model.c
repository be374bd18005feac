#include "numerics/momentum.h"
#include "numerics/onset.h"

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    double v;
    const double friction = unexplained(w, u->x_enc, u->F_m, u->F_in, &v, p); /* [N] */

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
    const double share = onset(w, u->v_r, p) * p->share;
    w->F_held = u->F_in + share * w->a * (p->coulomb != 0.0 ? direction : 1.0);
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s),
                  .x_last = u->x_enc,
                  .N_last = u->F_m - p->F_0,
                  .N_before = 0.5 * (u->F_m - p->F_0),
                  .N = u->F_m - p->F_0,
                  .a = p->a_0,
                  .v_last = u->v_r};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
    y->a_hat = w->a;
}
