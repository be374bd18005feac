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

void model_continuous(double t, const States *x, const Inputs *u, const Parameters *p,
                      Derivatives *dx, Outputs *y) {
    const LuGre contact = LUGRE_OF(p);
    dx->z = lugre_dz(u->v, x->z, &contact);
    y->F_f = lugre_force(u->v, x->z, &contact) + p->b * u->v;
    y->F_mean = y->F_f; /* there is no step to take a mean over */
}

void model_jacobian(double t, const States *x, const Memory *w, const Inputs *u,
                    const Parameters *p, Jacobian *J) {
    const LuGre contact = LUGRE_OF(p);
    lugre_slopes(u->v, x->z, &contact, &J->dx.z.u.v, &J->dx.z.x.z);
    double by_v, by_z;
    lugre_slopes(w ? u->v + p->lead * w->a : u->v, x->z, &contact, &by_v, &by_z);
    J->y.F_f.u.v = p->sigma_1 * by_v + p->b;
    J->y.F_f.x.z = p->sigma_0 + p->sigma_1 * by_z;
    if (!w) /* with steps F_mean belongs to the last one */
        J->y.F_mean = J->y.F_f;
}
