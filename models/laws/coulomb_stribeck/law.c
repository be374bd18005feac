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

#if LAW_SWITCHES
static double sign_of(double a) { return a > 0.0 ? 1.0 : a < 0.0 ? -1.0 : 0.0; }

static double absolute(double a) { return a < 0.0 ? -a : a; }

double law_flow(double v, double u, const LawState *s, const Law *p, LawRate *rate) {
    (void)rate;
    return s->mode == 0.0 ? u : s->mode * stribeck_curve(v, p->F_s, p->F_c, p->v_s, p->delta);
}

void law_events(double v, double u, const LawState *s, const Law *p, LawEvents *z) {
    z->margin =
        LAW_EDGE + (s->mode == 0.0 ? (p->F_s - absolute(u)) / p->F_s : s->mode * v / p->v_s);
}

bool law_switch(double *v, double u, LawState *s, const Law *p) {
    const double before = *v;
    if (before != 0.0 && s->mode * before >= 0.0) {
        s->mode = sign_of(before);
        return false;
    }
    s->mode = absolute(u) <= p->F_s ? 0.0 : sign_of(u);
    if (s->mode * before <= 0.0)
        *v = 0.0;
    return *v != before;
}
#endif
