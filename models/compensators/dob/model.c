#include "numerics/axis_filter.h"
#include "numerics/onset.h"

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    w->d_1 += p->L_1 * axis_sample(w, u->x_enc, u->F_m, u->F_in, p);
    w->d += p->T_s * w->d_1; /* in the period that begins */
    w->F_held = u->F_in - onset(w, u->v_r, p) * p->share * w->d;
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .x = u->x_enc, .N_last = u->F_m - p->F_0};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
    y->d_hat = w->d;
}
