#include "laws/law.h"

#include <stddef.h>

#include "laws/stribeck.h"

enum { ELEMENTS = sizeof((Law *)NULL)->kappa / sizeof(double) };

enum { SUB_STEPS = 16 }; /* where n_h is not 1 */

/* What holds over a step. */
typedef struct {
    double G;               /* [N]   steady friction */
    double k[ELEMENTS];     /* [N/m] stiffness of each element */
    double limit[ELEMENTS]; /* [m]   deflection at which it slips; the last one never does */
} Contact;

static Contact contact_at(double v, const Law *p) {
    Contact c = {.G = stribeck_curve(v, p->F_s, p->F_c, p->v_s, p->delta)};
    double shares = 0.0;
    for (size_t i = 0; i < ELEMENTS; i++)
        shares += p->kappa[i];
    const double unit = p->sigma_0 / shares;
    for (size_t i = 0; i < ELEMENTS; i++) {
        c.k[i] = unit * p->kappa[i];
        c.limit[i] = i + 1 == ELEMENTS ? 1e30 : c.k[i] > 0.0 ? p->W[i] * p->F_c / c.k[i] : 0.0;
    }
    return c;
}

/* Force of the elements [N]. */
static double hysteresis(const LawState *s, const Contact *c) {
    double force = 0.0;
    for (size_t i = 0; i < ELEMENTS; i++)
        force += c->k[i] * s->q[i];
    return force;
}

/* r^n for r >= 0; 0^0 = 1 */
static double power(double r, double n) {
    return n == 1.0 ? r : n == 0.0 ? 1.0 : r > 0.0 ? elementary_exp(n * elementary_log(r)) : 0.0;
}

/* dz/dt [m/s] at the share r [1] of steady friction in the direction of v. */
static double stretching(double v, double r, const Law *p) {
    return v * (1.0 - (r < 0.0 ? -power(-r, p->n_h) : power(r, p->n_h)));
}

/* Go up to h [s], until an element starts to slip, with the rate of z linear in z. Returns the time
 * gone; *impulse [N s] grows by the integral of the elements' force and *way [m] by that of dz/dt.
 */
static double piece(double h, double v, const Contact *c, LawState *s, const Law *p,
                    double *impulse, double *way) {
    const double force = hysteresis(s, c), r = (v < 0.0 ? -force : force) / c->G;
    const double rate = stretching(v, r, p), sign = rate < 0.0 ? -1.0 : 1.0;
    double k = 0.0; /* [N/m] of the elements that do not slip */
    for (size_t i = 0; i < ELEMENTS; i++)
        k += sign * s->q[i] < c->limit[i] ? c->k[i] : 0.0;
    const double per_reach = k * absolute(v) / c->G; /* [1/s] */
    double near = absolute(r); /* below 1 the slope of r^n has no bound at 0 */
    if (p->n_h < 1.0 && near < per_reach * h)
        near = per_reach * h < 1.0 ? per_reach * h : 1.0;
    const double fade = per_reach * p->n_h * power(near, p->n_h - 1.0); /* [1/s] */
    double t = h, phi2 = elementary_phi2(fade * h);
    double dz = h * (1.0 - fade * h * phi2) * rate;
    size_t first = ELEMENTS;
    for (size_t i = 0; i + 1 < ELEMENTS; i++) {
        const double left = c->limit[i] - sign * s->q[i];
        if (left <= 0.0 || left >= absolute(dz))
            continue;
        const double y = left * fade / absolute(rate); /* of the way that z would go for ever */
        const double reached =
            y < 1e-8 ? left / absolute(rate) * (1.0 + 0.5 * y) : -elementary_log(1.0 - y) / fade;
        if (reached < t) {
            t = reached;
            first = i;
            phi2 = elementary_phi2(fade * t);
            dz = t * (1.0 - fade * t * phi2) * rate;
        }
    }
    for (size_t i = 0; i < ELEMENTS; i++)
        if (sign * s->q[i] < c->limit[i])
            s->q[i] += dz;
    if (first < ELEMENTS)
        s->q[first] = sign * c->limit[first];
    *impulse += t * (force + k * t * phi2 * rate);
    *way += dz;
    return t;
}

double law_force(double v, const LawState *s, const Law *p) {
    const Contact c = contact_at(v, p);
    const double force = hysteresis(s, &c);
    return force + p->sigma_1 * stretching(v, (v < 0.0 ? -force : force) / c.G, p);
}

double law_step(double h, double v, LawState *s, const Law *p) {
    const Contact c = contact_at(v, p);
    for (size_t i = 0; i < ELEMENTS; i++) { /* limits may have changed */
        const double q = c.limit[i];
        s->q[i] = s->q[i] > q ? q : s->q[i] < -q ? -q : s->q[i];
    }
    if (v == 0.0)
        return hysteresis(s, &c);
    const int count = p->n_h == 1.0 ? 1 : SUB_STEPS;
    double impulse = 0.0, way = 0.0;
    for (int k = 0; k < count; k++)
        for (double left = h / (double)count; left > 0.0;)
            left -= piece(left, v, &c, s, p, &impulse, &way);
    return (impulse + p->sigma_1 * way) / h;
}

#if LAW_SWITCHES
/* Share of its limit after which an element that returns does not slip any more. */
static const double RETURNED = 1e-6;

/* dz/dt [m/s] */
static double bristle_rate(double v, const LawState *s, const Contact *c, const Law *p) {
    const double force = hysteresis(s, c);
    return stretching(v, (v < 0.0 ? -force : force) / c->G, p);
}

double law_flow(double v, double u, const LawState *s, const Law *p, LawRate *rate) {
    const Contact c = contact_at(v, p);
    const double dz = bristle_rate(v, s, &c, p);
    (void)u;
    for (size_t i = 0; i < ELEMENTS; i++)
        rate->q[i] = i + 1 < ELEMENTS && (s->slip[i] * dz > 0.0 || c.limit[i] <= 0.0) ? 0.0 : dz;
    return hysteresis(s, &c) + p->sigma_1 * dz;
}

/* Above 0 while a slipping element is at its limit [1]. It returns without an event; that it has
 * returned is an event. */
static double at_limit(size_t i, const Contact *c, const LawState *s) {
    return s->slip[i] * s->q[i] / c->limit[i] - (1.0 - RETURNED);
}

void law_events(double v, double u, const LawState *s, const Law *p, LawEvents *z) {
    const Contact c = contact_at(v, p);
    const double speed = bristle_rate(v, s, &c, p) / p->v_s;
    (void)u;
    for (size_t i = 0; i + 1 < ELEMENTS; i++) {
        const double below = 1.0 - absolute(s->q[i]) / c.limit[i];
        const double relief = s->q[i] < 0.0 ? speed : -speed;
        z->margin[i] = c.limit[i] <= 0.0   ? 1.0
                       : s->slip[i] != 0.0 ? at_limit(i, &c, s)
                       : below > relief    ? below
                                           : LAW_EDGE + relief;
    }
}

bool law_switch(double *v, double u, LawState *s, const Law *p) {
    const Contact c = contact_at(*v, p);
    bool changed = false;
    (void)u;
    for (size_t i = 0; i + 1 < ELEMENTS; i++) {
        const double most = c.limit[i], q = s->q[i];
        s->q[i] = q > most ? most : q < -most ? -most : q;
        changed = changed || s->q[i] != q;
    }
    const double dz = bristle_rate(*v, s, &c, p);
    for (size_t i = 0; i + 1 < ELEMENTS; i++) {
        if (c.limit[i] <= 0.0 || (s->slip[i] != 0.0 && at_limit(i, &c, s) > 0.0))
            continue;
        const double side = s->q[i] < 0.0 ? -1.0 : 1.0;
        s->slip[i] = side * s->q[i] >= c.limit[i] && side * dz > 0.0 ? side : 0.0;
    }
    return changed;
}
#endif
