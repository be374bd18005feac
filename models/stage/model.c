#include "model.h"

#include "friction/sliding_mass.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    w->dt = 0.0;
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const SlidingMass mass = {.m = p->m, .b = p->b, .u = u->u, .contact = LUGRE_OF(p)};
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
