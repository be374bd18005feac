#include "model.h"

#include "numerics/linear.h"

/* One sample: x+ = A x + B v_cmd + E a_cmd, v_r = C x+ + D v_cmd. */
static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    linear_step(w->x, p->A, p->B, u->v_cmd, p->E, u->a_cmd);
    w->v_held = linear_output(p->C, w->x) + p->D * u->v_cmd;
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s)};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->v_r = w->v_held;
}
