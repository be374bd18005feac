#include "model.h"

#include "numerics/position_force.h"

static double force(const Inputs *u, const Parameters *p) {
    return u->F_in * (1.0 + friction_of_weight(u->x, p) / p->F_c) + position_force(u->x, p);
}

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.F_held = force(u, p)};
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    w->F_held = force(u, p);             /* [N] */
    return w->F_held - w->F_held == 0.0; /* finite */
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
}
