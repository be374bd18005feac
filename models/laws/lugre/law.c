#include "laws/law.h"

#include "laws/lugre/lugre.h"

double law_force(double v, const LawState *s, const Law *p) {
    const LuGre contact = LUGRE_OF(p);
    return lugre_force(v, s->z, &contact);
}

double law_step(double h, double v, LawState *s, const Law *p) {
    const LuGre contact = LUGRE_OF(p);
    return lugre_step(h, v, &s->z, &contact);
}

void law_rate(double v, const LawState *s, const Law *p, LawRate *rate) {
    const LuGre contact = LUGRE_OF(p);
    rate->z = lugre_dz(v, s->z, &contact);
}

void law_jacobian(double v, const LawState *s, const Law *p, LawJacobian *J) {
    const LuGre contact = LUGRE_OF(p);
    lugre_slopes(v, s->z, &contact, &J->z.v, &J->z.z);
    double slope;
    const double damping = lugre_damping(v, &contact, &slope);
    J->F.v = damping * J->z.v + slope * lugre_dz(v, s->z, &contact);
    J->F.z = p->sigma_0 + damping * J->z.z;
}
