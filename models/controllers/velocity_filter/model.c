#include "numerics/axis_filter.h"

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    axis_sample(w, u->x_enc, u->F_m, u->F_ff, p);
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .x = u->x_enc, .N_last = u->F_m - p->F_0};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->v_hat = w->v;
    y->d_hat = w->d;
}
