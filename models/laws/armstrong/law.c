#include "laws/law.h"

#include <stddef.h>

enum { INTERVALS = sizeof((LawState *)NULL)->v_past / sizeof(double) };

static const double WHOLE = 1e-9; /* what may lack of an interval by rounding, as its share */

/* Square root of a normal x > 0, else 0. */
static double root(double x) {
    if (!(x > 1e-300))
        return 0.0;
    const double near = elementary_exp(0.5 * elementary_log(x));
    return 0.5 * (near + x / near);
}

/* Share of the Stribeck force above Coulomb friction that is left at a velocity. */
static double lorentz(double v, const Law *p) {
    const double ratio = v / p->v_s;
    return 1.0 / (1.0 + ratio * ratio);
}

/* The same at the delayed velocity, with v now. */
static double late_share(double v, const LawState *s, const Law *p) {
    return lorentz(p->tau_L > 0.0 ? s->v_past[INTERVALS - 1] : v, p);
}

/* Force of sliding [N], without its sign, at a share of the force above Coulomb friction. */
static double sliding(double share, const Law *p) { return p->F_c + share * (p->F_s - p->F_c); }

/* Let h [s] pass at velocity v; returns the integral [s] of the share at the delayed velocity. */
static double remember(double h, double v, LawState *s, const Law *p) {
    if (p->tau_L <= 0.0)
        return h * lorentz(v, p);
    const double interval = p->tau_L / (double)INTERVALS;
    double shares = 0.0;
    for (int n = 0; h > 0.0; n++) {
        /* Then nothing but v is left in the memory. */
        const double whole = n > INTERVALS ? interval * nearest(h / interval - 0.5) : 0.0;
        if (whole > 0.0) {
            shares += whole * lorentz(v, p);
            h -= whole;
            continue;
        }
        const double left = interval - s->t_now;
        const bool ends = h > left - WHOLE * interval;
        const double t = ends && left < h ? left : h;
        shares += t * lorentz(s->v_past[INTERVALS - 1], p);
        s->x_now += t * v;
        s->t_now += t;
        h -= t;
        if (ends) {
            for (size_t i = INTERVALS - 1; i > 0; i--)
                s->v_past[i] = s->v_past[i - 1];
            s->v_past[0] = s->x_now / s->t_now;
            s->x_now = s->t_now = 0.0;
        }
    }
    return shares;
}

/* Share of the rise of static friction after a time at rest [s], from that at its beginning. */
static double risen(double first, double time, const Law *p) {
    return p->gamma > 0.0 ? first + (1.0 - first) * time / (time + p->gamma) : 1.0;
}

/* Whether the spring, stretched at v for h [s], does not carry static friction by then. */
static bool holds(double h, double v, const LawState *s, const Law *p) {
    return sign_of(v) * p->k_t * (s->d + v * h) <= sliding(risen(s->share, s->t_2 + h, p), p);
}

/* Time [s] until it does: the solution t >= 0 of
 *   s k_t (d + v t) = F_c + (F_s - F_c) risen(t_2 + t),    s = sgn(v). */
static double break_away(double v, const LawState *s, const Law *p) {
    const double rate = p->k_t * absolute(v); /* [N/s] */
    const double force = sign_of(v) * p->k_t * s->d;
    const double lack = sliding(risen(s->share, s->t_2, p), p) - force;
    if (lack <= 0.0)
        return 0.0;
    if (p->gamma <= 0.0)
        return lack / rate;
    /* With the time T = t_2 + gamma at the beginning:  rate t = lack + rise t / (T + t) */
    const double T = s->t_2 + p->gamma;
    const double rise = (p->F_s - p->F_c) * (1.0 - s->share) * p->gamma / T;
    const double half = 0.5 * (lack + rise - rate * T), end = root(half * half + rate * lack * T);
    return half > 0.0 ? (half + end) / rate : lack * T / (end - half);
}

/* The motion ends: the spring takes the force over. */
static void stop(LawState *s, const Law *p) {
    s->share *= late_share(0.0, s, p);
    s->d = s->mode * sliding(s->share, p) / p->k_t;
    s->mode = 0.0;
    s->t_2 = 0.0;
}

double law_force(double v, const LawState *s, const Law *p) {
    LawState now = *s;
    if (now.mode != 0.0 && now.mode == sign_of(v))
        return now.mode * sliding(now.share * late_share(v, s, p), p);
    if (now.mode != 0.0)
        stop(&now, p);
    return p->k_t * now.d + p->sigma_t * v;
}

double law_step(double h, double v, LawState *s, const Law *p) {
    if (s->mode != 0.0 && s->mode != sign_of(v))
        stop(s, p);
    double impulse = 0.0, left = h; /* [N s], [s] */
    if (s->mode == 0.0) {
        const double t = holds(h, v, s, p) ? h : break_away(v, s, p);
        impulse = t * (p->k_t * (s->d + 0.5 * v * t) + p->sigma_t * v);
        s->d += v * t;
        s->t_2 += t;
        left = h - t;
        remember(t, v, s, p);
        if (left <= 0.0)
            return impulse / h;
        s->mode = sign_of(v);
        s->share = risen(s->share, s->t_2, p);
    }
    const double shares = remember(left, v, s, p);
    impulse += s->mode * (left * p->F_c + shares * s->share * (p->F_s - p->F_c));
    return impulse / h;
}
