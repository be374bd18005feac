#include "model.h"

#include "friction/lugre.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const LuGre contact = LUGRE_OF(p);
    x->z = lugre_step(h, u->v, x->z, &contact);
    return x->z - x->z == 0.0; /* finite */
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    const LuGre contact = LUGRE_OF(p);
    y->F_f = lugre_force(u->v, x->z, &contact) + p->b * u->v;
}
