#include "laws/law.h"
#include "numerics/command.h"

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    const double v = expected_velocity(w, u, p);
    w->F_held = law_step(p->T_s, v, w, p) + p->b * v;
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
