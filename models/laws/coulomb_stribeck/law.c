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

#if LAW_SWITCHES
double law_flow(double v, double u, const LawState *s, const Law *p, LawRate *rate) {
    (void)rate;
    return s->mode == 0.0 ? u : s->mode * stribeck_curve(v, p->F_s, p->F_c, p->v_s, p->delta);
}

/* Margin of the present mode, above 0 while it holds. A motion does not end where the driving force
 * is larger than F_s in its direction: a velocity of the other sign is an error of the solver. */
static double margin(double v, double u, const LawState *s, const Law *p) {
    if (s->mode == 0.0)
        return (p->F_s - absolute(u)) / p->F_s;
    const double driven = (s->mode * u - p->F_s) / p->F_s, moving = s->mode * v / p->v_s;
    return driven > moving ? driven : moving;
}

void law_events(double v, double u, const LawState *s, const Law *p, LawEvents *z) {
    z->margin = LAW_EDGE + margin(v, u, s, p);
}

bool law_switch(double *v, double u, LawState *s, const Law *p) {
    const double before = *v;
    if (s->mode != 0.0 && margin(before, u, s, p) > 0.0)
        return false;
    if (s->mode == 0.0 && before != 0.0) {
        s->mode = sign_of(before);
        return false;
    }
    s->mode = absolute(u) <= p->F_s ? 0.0 : sign_of(u);
    if (s->mode * before <= 0.0)
        *v = 0.0;
    return *v != before;
}
#endif
