#include "numerics/command.h"
#include "numerics/elementary.h"

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    const double v = expected_velocity(w, u, p);
    const double side = v < 0.0 ? 1.0 - p->asymmetry : 1.0 + p->asymmetry; /* [1] */
    w->F_held = side * p->F_c * clipped(v / p->v_t) + p->b * v;            /* [N] */
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .x_last = u->x_cmd, .v_last = p->loop_D * u->v_cmd};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F_ff = w->F_held;
    y->v_r = w->v_held;
}
