#include "model.h"

#include "friction/sliding_mass.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    w->dt = 0.0;
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const SlidingMass mass = {.per_m = 1.0 / p->m, .b = p->b, .u = u->u, .contact = LUGRE_OF(p)};
    Motion motion = {x->x, x->v, x->z};
    if (!sliding_mass_step(h, &motion, &mass, &w->dt))
        return false;
    *x = (States){motion.x, motion.v, motion.z};
    return true;
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    const LuGre bristles = LUGRE_OF(p);
    y->F_f = lugre_force(x->v, x->z, &bristles);
}

void model_continuous(double t, const States *x, const Inputs *u, const Parameters *p,
                      Derivatives *dx, Outputs *y) {
    const LuGre bristles = LUGRE_OF(p);
    y->F_f = lugre_force(x->v, x->z, &bristles);
    dx->x = x->v;
    dx->v = (u->u - p->b * x->v - y->F_f) / p->m; /* (1) */
    dx->z = lugre_dz(x->v, x->z, &bristles);      /* (2) */
}

void model_jacobian(double t, const States *x, const Memory *w, const Inputs *u,
                    const Parameters *p, Jacobian *J) {
    const LuGre bristles = LUGRE_OF(p);
    Gradient *dz = &J->dx.z, *F_f = &J->y.F_f;
    lugre_slopes(x->v, x->z, &bristles, &dz->x.v, &dz->x.z);
    F_f->x.v = p->sigma_1 * dz->x.v;
    F_f->x.z = p->sigma_0 + p->sigma_1 * dz->x.z;
    J->dx.x.x.v = 1.0;
    J->dx.v.x.v = -(p->b + F_f->x.v) / p->m;
    J->dx.v.x.z = -F_f->x.z / p->m;
    J->dx.v.u.u = 1.0 / p->m;
}
