#include "model.h"

#include "numerics/elementary.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.v_last = u->v};
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const double a = (u->v - w->v_last) / h;                               /* [m/s2] */
    const double v = 0.5 * (w->v_last + u->v) + p->lead * a;               /* [m/s] */
    const double side = v < 0.0 ? 1.0 - p->asymmetry : 1.0 + p->asymmetry; /* [1] */
    w->F_held = u->F_in + side * p->F_c * clipped(v / p->v_t) + p->b * v;  /* [N] */
    w->v_last = u->v;
    return w->F_held - w->F_held == 0.0; /* finite */
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
}
