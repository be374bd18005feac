#include "model.h"

#include "friction/lugre.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.v_last = u->v};
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const LuGre contact = LUGRE_OF(p);
    w->a = (u->v - w->v_last) / h;
    const double v = (p->hold != 0.0 ? u->v : 0.5 * (w->v_last + u->v)) + p->lead * w->a;
    w->F_held = lugre_step(h, v, &x->z, &contact) + p->b * v;
    w->v_last = u->v;
    return w->F_held - w->F_held == 0.0; /* finite */
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    const LuGre contact = LUGRE_OF(p);
    const double v = u->v + p->lead * w->a;
    y->F_f = lugre_force(v, x->z, &contact) + p->b * v;
    y->F_mean = w->F_held;
}
