#include "laws/elasto_plastic/elasto_plastic.h"

#include "laws/stribeck.h"

/* At constant v the share of steady friction r = s sigma_0 z / g(v) [1], s = sgn(v), follows
 *
 *   dr/dy = 1 - alpha r,    alpha = 0                                        r <= rho
 *                                   (1 - cos(pi (r - rho) / (1 - rho))) / 2  rho < r < 1
 *                                   1                                        r >= 1
 *
 * along the displacement y = sigma_0 |v| t / g(v) [1]; rho [1] is the break-away deflection.
 */

enum { ORDER = 12 }; /* of the Taylor series between rho and 1 */

static const double PI = 3.141592653589793;
static const double LOCAL = 1e-14; /* error of r allowed in one series */
static const double BENT = 1e-3;   /* kappa^2 e at which three terms of a logarithm are enough */

static double g(double v, const Law *p) {
    return stribeck_curve(v, p->F_s, p->F_c, p->v_s, p->delta);
}

/* The break-away deflection as a share of steady friction G [N]. */
static double break_away(double G, const Law *p) { return p->z_ba * p->F_c / G; }

/* alpha(r); *slope receives its derivative. */
static double slipping(double r, double rho, double *slope) {
    const double angle = PI * (r - rho) / (1.0 - rho);
    *slope = r <= rho || r >= 1.0 ? 0.0 : 0.5 * PI / (1.0 - rho) * elementary_sin(angle);
    if (r <= rho || r >= 1.0)
        return r <= rho ? 0.0 : 1.0;
    const double root = elementary_sin(0.5 * angle);
    return root * root;
}

/* Go the displacement y <= 1 or less from a share *r between rho and 1 by a Taylor series. Returns
 * the displacement; *area grows by the integral of r over it. */
static double transition(double y, double rho, double *r, double *area) {
    const double scale = PI / (1.0 - rho);
    const double angle = scale * (*r - rho);
    double share[ORDER + 1], turn[ORDER + 1];  /* coefficients of r, of d(angle)/dy, */
    double sine[ORDER + 1], cosine[ORDER + 1]; /* of sin and cos of the angle */
    share[0] = *r;
    sine[0] = elementary_sin(angle);
    cosine[0] = elementary_sin(angle + 0.5 * PI);
    double power = 1.0, last = 1.0, earlier = 1.0; /* from rho = 0 two of three terms are 0 */
    int order = 0;
    for (int n = 0; n < ORDER; n++) {
        double elastic = 0.0, d_sine = 0.0, d_cosine = 0.0; /* elastic: of cos r */
        for (int j = 0; j <= n; j++)
            elastic += cosine[n - j] * share[j];
        const double rate = (n == 0 ? 1.0 : 0.0) - 0.5 * (share[n] - elastic);
        turn[n] = scale * rate;
        for (int j = 0; j <= n; j++) {
            d_sine += turn[j] * cosine[n - j];
            d_cosine -= turn[j] * sine[n - j];
        }
        order = n + 1;
        const double per_order = 1.0 / (double)(n + 1);
        share[n + 1] = rate * per_order;
        sine[n + 1] = d_sine * per_order;
        cosine[n + 1] = d_cosine * per_order;
        power *= y;
        const double term = absolute(share[n + 1]) * power;
        if (term + last + earlier < LOCAL)
            break;
        earlier = last;
        last = term;
    }
    double step = y;
    if (order == ORDER) {
        const double size = absolute(share[ORDER]) + scale * absolute(share[ORDER - 1]) +
                            scale * scale * absolute(share[ORDER - 2]);
        step = elementary_exp(elementary_log(LOCAL / size) / (double)ORDER);
        step = step < y ? step : y;
    }
    double end = 0.0, mean = 0.0;
    for (int n = ORDER; n >= 0; n--) {
        if (n > order)
            continue;
        end = end * step + share[n];
        mean = mean * step + share[n] / (double)(n + 1);
    }
    *area += step * mean;
    *r = end;
    return step;
}

/* kappa^2 in 1 - alpha = sin(kappa e)^2, with the lack e = 1 - r. */
static double curvature(double rho) {
    const double kappa = 0.5 * PI / (1.0 - rho);
    return kappa * kappa;
}

/* Whether de/dy = -e - kappa^2 e^2 + kappa^2 e^3 + ... needs its first two terms only, or r >= 1.
 * Then 1 / e + kappa^2 grows as e^y. */
static bool is_close(double lack, double rho) {
    const double bent = curvature(rho) * lack;
    return bent * lack * lack < LOCAL && bent < BENT;
}

/* Go the displacement y [1] from the share *r; returns the integral of r over it. */
static double travel(double y, double rho, double *r) {
    double area = 0.0;
    if (*r < rho) {
        const double elastic = rho - *r < y ? rho - *r : y;
        area = elastic * (*r + 0.5 * elastic);
        *r += elastic;
        y -= elastic;
    }
    while (y > 0.0 && !is_close(1.0 - *r, rho))
        y -= transition(y < 1.0 ? y : 1.0, rho, r, &area);
    if (y > 0.0) {
        const double lack = 1.0 - *r, way = y * elementary_phi(y); /* 1 - e^-y */
        const double bent = lack > 0.0 ? curvature(rho) * lack * way : 0.0;
        area += y - lack * way * (1.0 - bent * (0.5 - bent / 3.0));
        *r = 1.0 - lack * (1.0 - way) / (1.0 + bent);
    }
    return area;
}

double elasto_plastic_dz(double v, double side, double z, double scale, const Law *p, double *by_v,
                         double *by_z) {
    const double G = g(v, p), rho = break_away(G, p);
    const double per_reach = p->sigma_0 / (scale * G), r = side * z * per_reach;
    double slope;
    const double alpha = slipping(r, rho, &slope), share = 1.0 - alpha * r;
    const double steepness = stribeck_slope(v, p->F_s, p->F_c, p->v_s, p->delta) / G;
    const double by_g = -slope * (r - rho) / (1.0 - rho); /* g dalpha/dg */
    *by_v = share + steepness * r * (alpha - by_g);
    *by_z = -(alpha + slope * r) * per_reach * absolute(v);
    return v * share;
}

/* dz/dt [m/s] */
static double stretching(double v, const LawState *s, const Law *p) {
    double by_v, by_z;
    return elasto_plastic_dz(v, side_of(v), s->z, 1.0, p, &by_v, &by_z);
}

double law_force(double v, const LawState *s, const Law *p) {
    return p->sigma_0 * s->z + p->sigma_1 * stretching(v, s, p);
}

double law_step(double h, double v, LawState *s, const Law *p) {
    if (v == 0.0)
        return p->sigma_0 * s->z;
    const double G = v < 0.0 ? -g(v, p) : g(v, p), per_reach = p->sigma_0 / G; /* [1/m] */
    const double y = v * h * per_reach, before = s->z * per_reach;
    double r = before;
    const double mean = travel(y, break_away(absolute(G), p), &r) / y;
    const double dz = (r - before) / per_reach;
    s->z += dz;
    return G * mean + p->sigma_1 * dz / h;
}

void law_rate(double v, const LawState *s, const Law *p, LawRate *rate) {
    rate->z = stretching(v, s, p);
}

void law_jacobian(double v, const LawState *s, const Law *p, LawJacobian *J) {
    const double side = v != 0.0 ? side_of(v) : side_of(s->z);
    double by_v;
    elasto_plastic_dz(v, side, s->z, 1.0, p, &by_v, &J->z.z);
    /* At rest the side of the deflection slips, and the other one is elastic. */
    J->z.v = v != 0.0 ? by_v : 0.5 * (by_v + 1.0);
    J->F.v = p->sigma_1 * J->z.v;
    J->F.z = p->sigma_0 + p->sigma_1 * J->z.z;
}
