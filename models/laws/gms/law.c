#include "laws/law.h"

#include <stddef.h>

#include "laws/stribeck.h"

enum { ELEMENTS = sizeof((Law *)NULL)->alpha / sizeof(double) };

static double g(double v, const Law *p) {
    return stribeck_curve(v, p->F_s, p->F_c, p->v_s, p->delta);
}

static double sum(const double values[]) {
    double total = 0.0;
    for (size_t i = 0; i < ELEMENTS; i++)
        total += values[i];
    return total;
}

/* Damping of the elements, which act side by side [N]: `rate` [N/s] is that of their forces. */
static double damping(double rate, const Law *p) { return p->sigma_1 * rate / p->sigma_0; }

double law_force(double v, const LawState *s, const Law *p) {
    const double G = g(v, p), alpha = 1.0 / sum(p->alpha), k = p->sigma_0 / sum(p->kappa);
    const double sign = v < 0.0 ? -1.0 : 1.0;
    double rate = 0.0; /* [N/s] */
    for (size_t i = 0; v != 0.0 && i < ELEMENTS; i++) {
        const double limit = alpha * p->alpha[i] * G;
        const bool slips = s->mode[i] == sign || sign * s->F_e[i] >= limit;
        rate += slips ? p->C * (sign * limit - s->F_e[i]) / G : k * p->kappa[i] * v;
    }
    return sum(s->F_e) + damping(rate, p);
}

double law_step(double h, double v, LawState *s, const Law *p) {
    const double before = sum(s->F_e);
    if (v == 0.0) {
        for (size_t i = 0; i < ELEMENTS; i++)
            s->mode[i] = 0.0;
        return before;
    }
    const double G = g(v, p), alpha = 1.0 / sum(p->alpha), k = p->sigma_0 / sum(p->kappa);
    const double sign = v < 0.0 ? -1.0 : 1.0;
    const double decay = p->C / G, whole = elementary_phi(decay * h); /* [1/s], [1] */
    double impulse = 0.0;                                             /* [N s] */
    for (size_t i = 0; i < ELEMENTS; i++) {
        const double limit = alpha * p->alpha[i] * G; /* [N] */
        const double rate = k * p->kappa[i] * v;      /* [N/s] */
        const double lack = limit - sign * s->F_e[i]; /* [N] */
        double slipping = h, phi = whole;             /* [s], [1] */
        if (s->mode[i] != sign && lack > 0.0) {
            const bool holds = lack >= sign * rate * h;
            const double sticking = holds ? h : lack / (sign * rate); /* [s] */
            impulse += sticking * (s->F_e[i] + 0.5 * rate * sticking);
            s->F_e[i] += rate * sticking;
            s->mode[i] = holds ? 0.0 : sign;
            slipping = h - sticking;
            phi = holds ? 1.0 : elementary_phi(decay * slipping);
        } else {
            s->mode[i] = sign;
        }
        const double excess = s->F_e[i] - sign * limit;
        impulse += slipping * (sign * limit + excess * phi);
        s->F_e[i] -= excess * decay * slipping * phi;
    }
    return impulse / h + damping((sum(s->F_e) - before) / h, p);
}

#if LAW_SWITCHES
/* Force [N] that a sticking element still lacks to its share of the Stribeck curve. */
static double reserve(size_t i, double G, const LawState *s, const Law *p) {
    return p->alpha[i] / sum(p->alpha) * G - absolute(s->F_e[i]);
}

/* Velocity in the direction of an element's force. */
static double stretching(size_t i, double v, const LawState *s) {
    return s->F_e[i] < 0.0 ? -v : s->F_e[i] > 0.0 ? v : absolute(v);
}

double law_flow(double v, double u, const LawState *s, const Law *p, LawRate *rate) {
    const double G = g(v, p), alpha = 1.0 / sum(p->alpha), k = p->sigma_0 / sum(p->kappa);
    double total = 0.0; /* [N/s] */
    (void)u;
    for (size_t i = 0; i < ELEMENTS; i++) {
        const double limit = s->mode[i] * alpha * p->alpha[i] * G;
        rate->F_e[i] = s->mode[i] != 0.0 ? p->C * (limit - s->F_e[i]) / G : k * p->kappa[i] * v;
        total += rate->F_e[i];
    }
    return sum(s->F_e) + damping(total, p);
}

/* An element sticks as long as its force is below its share, or the motion relieves it. */
void law_events(double v, double u, const LawState *s, const Law *p, LawEvents *z) {
    const double G = g(v, p);
    (void)u;
    for (size_t i = 0; i < ELEMENTS; i++) {
        const double below = reserve(i, G, s, p) / G, relief = -stretching(i, v, s) / p->v_s;
        const double sticking = below > relief ? below : relief;
        z->margin[i] = LAW_EDGE + (s->mode[i] != 0.0 ? s->mode[i] * v / p->v_s : sticking);
    }
}

bool law_switch(double *v, double u, LawState *s, const Law *p) {
    const double G = g(*v, p);
    (void)u;
    for (size_t i = 0; i < ELEMENTS; i++) {
        if (s->mode[i] * *v > 0.0)
            continue;
        const bool slips = reserve(i, G, s, p) <= 0.0 && stretching(i, *v, s) > 0.0;
        s->mode[i] = !slips ? 0.0 : *v < 0.0 ? -1.0 : 1.0;
    }
    return false;
}
#endif
