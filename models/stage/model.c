#include "model.h"

#include "friction/sliding_mass.h"

static double constant_force(double t, double dt, double x, const void *context) {
    return ((const Inputs *)context)->u;
}

static double even(double x, double v, const void *context) { return 1.0; }

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    w->dt = 0.0;
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const SlidingMass mass = {p->m, p->b, LUGRE_OF(p), constant_force, even, u};
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
