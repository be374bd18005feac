#include "laws/law.h"

/* dF_d/dt = sigma_0 (1 - s F_d / F_c) v,   s = sgn(v) */

double law_force(double v, const LawState *s, const Law *p) {
    (void)v, (void)p;
    return s->F_d;
}

double law_step(double h, double v, LawState *s, const Law *p) {
    if (v == 0.0)
        return s->F_d;
    const double F_end = v < 0.0 ? -p->F_c : p->F_c;        /* [N] */
    const double y = p->sigma_0 * absolute(v) * h / p->F_c; /* [1] */
    const double mean = elementary_phi(y), left = F_end - s->F_d;
    s->F_d = F_end - left * (1.0 - y * mean); /* left e^(-y) [N] */
    return F_end - left * mean;               /* [N] */
}

void law_rate(double v, const LawState *s, const Law *p, LawRate *rate) {
    const double F_end = v < 0.0 ? -p->F_c : p->F_c;
    rate->F_d = p->sigma_0 * (1.0 - s->F_d / F_end) * v; /* [N/s] */
}

void law_jacobian(double v, const LawState *s, const Law *p, LawJacobian *J) {
    const double side = v < 0.0 ? -1.0 : v > 0.0 ? 1.0 : 0.0;
    J->F.F_d = 1.0;
    J->F_d.v = p->sigma_0 * (1.0 - side * s->F_d / p->F_c);
    J->F_d.F_d = -p->sigma_0 * absolute(v) / p->F_c; /* [1/s] */
}
