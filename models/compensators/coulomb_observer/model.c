#include "numerics/axis_filter.h"
#include "numerics/onset.h"

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    const double expected = -w->a * w->s; /* disturbing force in the period that ends [N] */
    w->d = expected;
    axis_sample(w, u->x_enc, u->F_m, u->F_in, p);
    w->a -= w->s * (w->d - expected);

    const double slope = (u->v_r - w->v_last) / p->T_s; /* [m/s2] */
    const double v = 0.5 * (w->v_last + u->v_r);
    w->v_last = u->v_r;
    w->s = clipped((p->measured != 0.0 ? w->v : v) / p->v_t);
    const double early = p->measured != 0.0 ? w->s : clipped((v + p->lead * slope) / p->v_t);
    const double acceleration = (w->N_last - w->a * w->s - p->b * w->v) / p->m;
    const double returned = p->k_a * p->m * (acceleration - slope);
    w->F_held = u->F_in + onset(w, u->v_r, p) * (p->share * w->a * early - returned);
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s),
                  .x = u->x_enc,
                  .N_last = u->F_m - p->F_0,
                  .a = p->a_0,
                  .v_last = u->v_r};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
    y->a_hat = w->a;
}
