#include "model.h"

#include "laws/law.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.v_last = u->v};
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    w->a = (u->v - w->v_last) / h;
    const double v = (p->hold != 0.0 ? u->v : 0.5 * (w->v_last + u->v)) + p->lead * w->a;
    w->F_held = law_step(h, v, x, p) + p->b * v;
    w->v_last = u->v;
    return w->F_held - w->F_held == 0.0; /* finite */
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    const double v = u->v + p->lead * w->a;
    y->F_f = law_force(v, x, p) + p->b * v;
    y->F_mean = w->F_held;
}

#if LAW_IS_SMOOTH
void model_continuous(double t, const States *x, const Inputs *u, const Parameters *p,
                      Derivatives *dx, Outputs *y) {
    law_rate(u->v, x, p, dx);
    y->F_f = law_force(u->v, x, p) + p->b * u->v;
    y->F_mean = y->F_f; /* there is no step to take a mean over */
}

void model_jacobian(double t, const States *x, const Memory *w, const Inputs *u,
                    const Parameters *p, Jacobian *J) {
    LawJacobian now = {0}, early = {0};
    law_jacobian(u->v, x, p, &now);
    law_jacobian(w ? u->v + p->lead * w->a : u->v, x, p, &early);
    now.F = early.F;
    law_rows(&now, &J->y.F_f, J);
    J->y.F_f.u.v += p->b;
    if (!w) /* with steps F_mean belongs to the last one */
        J->y.F_mean = J->y.F_f;
}
#endif
