#include "laws/law.h"

#include "laws/stribeck.h"

double law_force(double v, const LawState *s, const Law *p) {
    const double sign = v > 0.0 ? 1.0 : v < 0.0 ? -1.0 : 0.0;
    return sign * stribeck_curve(v, p->F_s, p->F_c, p->v_s, p->delta) + s->F_h;
}

double law_step(double h, double v, LawState *s, const Law *p) {
    (void)h;
    return law_force(v, s, p);
}

Law law_scaled(const Law *p, double factor) {
    Law scaled = *p;
    scaled.F_s *= factor;
    scaled.F_c *= factor;
    return scaled;
}
