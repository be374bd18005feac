#include "model.h"

#include <stddef.h>

#include "plants/motion.h"

/* The guide is even. */
double plant_ripple(double x, const Mass *mass) { return 0.0; }

double plant_roughness(double x, double v, const Mass *mass) { return 1.0; }

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    w->dt = 0.0;
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const Mass mass = {.per_m = 1.0 / p->m, .b = p->b, .u = u->u, .p = p};
    Motion motion = {x->x, x->v};
    if (!motion_step(h, &motion, x, &mass, p, &w->dt))
        return false;
    x->x = motion.x;
    x->v = motion.v;
    return true;
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F_f = law_force(x->v, x, p);
}

#if LAW_SWITCHES
void model_continuous(double t, const States *x, const Inputs *u, const Parameters *p,
                      Derivatives *dx, Outputs *y) {
    const double driving = u->u - p->b * x->v;
    y->F_f = law_flow(x->v, driving, x, p, dx);
    dx->x = x->v;
    dx->v = (driving - y->F_f) / p->m; /* (1) */
}

void model_events(double t, const States *x, const Inputs *u, const Parameters *p, Indicators *z) {
    law_events(x->v, u->u - p->b * x->v, x, p, z);
}

bool model_switch(double t, States *x, const Inputs *u, const Parameters *p) {
    return law_switch(&x->v, u->u - p->b * x->v, x, p);
}
#elif LAW_IS_SMOOTH
void model_continuous(double t, const States *x, const Inputs *u, const Parameters *p,
                      Derivatives *dx, Outputs *y) {
    y->F_f = law_force(x->v, x, p);
    dx->x = x->v;
    dx->v = (u->u - p->b * x->v - y->F_f) / p->m; /* (1) */
    law_rate(x->v, x, p, dx);
}

void model_jacobian(double t, const States *x, const Memory *w, const Inputs *u,
                    const Parameters *p, Jacobian *J) {
    const double *force = (const double *)&J->y.F_f;
    double *acceleration = (double *)&J->dx.v;
    LawJacobian law = {0};
    law_jacobian(x->v, x, p, &law);
    law_rows(&law, &J->y.F_f, J);
    for (size_t k = 0; k < sizeof(Gradient) / sizeof(double); k++)
        acceleration[k] = -force[k] / p->m;
    J->dx.x.x.v = 1.0;
    J->dx.v.x.v = -(p->b + J->y.F_f.x.v) / p->m;
    J->dx.v.u.u = 1.0 / p->m;
}
#endif
