#include "laws/law.h"

/* What is left of the force until it is s F_c, as a share of F_c: r = 1 - s F_d / F_c [1]. Along
 * the way y = sigma_0 |x| / F_c [1] it follows dr/dy = -|r|^i sgn(r). */

static const double SHORT = 1e-3; /* ways up to which a series is exact to rounding */
static const double CLOSE = 1e-9; /* exponents that are taken to be equal */

/* x^p for x >= 0; 0^0 = 1 */
static double power(double x, double p) {
    return p == 0.0 ? 1.0 : x > 0.0 ? elementary_exp(p * elementary_log(x)) : 0.0;
}

/* |r|^i sgn(r) */
static double yielding(double r, double i) {
    return r < 0.0 ? -power(-r, i) : r > 0.0 ? power(r, i) : 0.0;
}

/* Go the way y from |r| = 1, in the scale of y in which that holds. Returns |r|, and its mean. */
static double yield(double y, double i, double *mean) {
    if (absolute(i - 1.0) < CLOSE) {
        *mean = elementary_phi(y);
        return 1.0 - y * *mean;
    }
    const double left = 1.0 + (i - 1.0) * y;
    const double end = left > 0.0 ? elementary_exp(elementary_log(left) / (1.0 - i)) : 0.0;
    if (y < SHORT) {
        const double second = i * (2.0 * i - 1.0), third = second * (3.0 * i - 2.0);
        *mean = 1.0 - y * (1.0 / 2.0 - y * (i / 6.0 - y * (second / 24.0 - y * third / 120.0)));
    } else if (2.0 - i < CLOSE) {
        *mean = -elementary_log(end) / y;
    } else {
        *mean = (1.0 - power(end, 2.0 - i)) / ((2.0 - i) * y);
    }
    return end;
}

double law_force(double v, const LawState *s, const Law *p) {
    (void)v, (void)p;
    return s->F_d;
}

double law_step(double h, double v, LawState *s, const Law *p) {
    if (v == 0.0)
        return s->F_d;
    const double F_end = v < 0.0 ? -p->F_c : p->F_c;
    const double r = 1.0 - s->F_d / F_end;
    const double y = p->sigma_0 * absolute(v) * h / p->F_c;
    if (r == 0.0)
        return s->F_d;
    double mean;
    const double left = yield(y * power(absolute(r), p->i - 1.0), p->i, &mean);
    const double F_mean = F_end * (1.0 - r * mean);
    s->F_d = F_end * (1.0 - r * left);
    return F_mean;
}

void law_rate(double v, const LawState *s, const Law *p, LawRate *rate) {
    const double F_end = v < 0.0 ? -p->F_c : p->F_c;
    rate->F_d = p->sigma_0 * yielding(1.0 - s->F_d / F_end, p->i) * v;
}

void law_jacobian(double v, const LawState *s, const Law *p, LawJacobian *J) {
    const double f = s->F_d / p->F_c;
    const double forward = yielding(1.0 - f, p->i), backward = yielding(1.0 + f, p->i);
    const double r = v < 0.0 ? 1.0 + f : 1.0 - f;
    J->F.F_d = 1.0;
    J->F_d.v = p->sigma_0 * (v > 0.0 ? forward : v < 0.0 ? backward : 0.5 * (forward + backward));
    J->F_d.F_d =
        -p->sigma_0 * absolute(v) / p->F_c * p->i * power(absolute(r), p->i - 1.0); /* [1/s] */
}
