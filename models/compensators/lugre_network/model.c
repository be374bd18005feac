#include <stddef.h>

#include "laws/lugre/lugre.h"
#include "numerics/feedback_learning.h"

/* Parameters that are learned, in the order of theta: F_c, sigma_0, sigma_1, F_s, v_s */
enum { LEARNED = 5 };

/* Derivatives of phi(y) = (1 - e^-y) / y and phi2(y) = (1 - phi(y)) / y */
static double phi_slope(double y) { return elementary_phi2(y) - elementary_phi(y); }

static double phi2_slope(double y) {
    if (y < 1e-3)
        return -1.0 / 6.0 + y * (1.0 / 12.0 - y * (1.0 / 40.0 - y / 180.0));
    return (elementary_phi(y) - 2.0 * elementary_phi2(y)) / y;
}

/* Go ahead by a period at v; returns the mean force [N] and writes its derivatives by the
 * logarithms of the parameters to `by` [N]. The bristle and its derivatives z_by are exact at
 * constant v. */
static double stepped(Memory *w, double v, const Parameters *p, double *by) {
    const double *t = w->theta;
    const LuGre c = {t[3], t[0], 1.0 / t[4], t[1], t[2], p->delta, p->v_d};
    const LuGre shape = {1.0, 0.0, c.per_v_s, c.sigma_0, c.sigma_1, c.delta, c.v_d};
    const double speed = v < 0.0 ? -v : v, h = p->T_s, z = w->z;
    double slope; /* |v| dg / d|v| [N] */
    const double g = lugre_g(v, &c, &slope), faded = lugre_g(v, &shape, NULL);
    const double a = c.sigma_0 * speed / g, y = a * h; /* [1/s], [1] */
    const double phi = elementary_phi(y), phi2 = elementary_phi2(y);
    /* a by the logarithm of each parameter */
    const double a_by[LEARNED] = {-a / g * c.F_c * (1.0 - faded), a, 0.0, -a / g * c.F_s * faded,
                                  a / g * slope};
    const double mean_z = z * phi + v * h * phi2;
    const double mean_z_by_a = h * (z * phi_slope(y) + v * h * phi2_slope(y));
    const double end_by_a = h * (v * h * phi_slope(y) - z * (1.0 - y * phi));
    const double force = lugre_step(h, v, &w->z, &c), sigma_1 = lugre_damping(v, &c, NULL);
    for (int i = 0; i < LEARNED; i++) {
        const double end_by = w->z_by[i] * (1.0 - y * phi) + end_by_a * a_by[i];
        const double mean_by = w->z_by[i] * phi + mean_z_by_a * a_by[i];
        by[i] = c.sigma_0 * mean_by + sigma_1 * (end_by - w->z_by[i]) / h;
        w->z_by[i] = end_by;
    }
    by[1] += c.sigma_0 * mean_z;
    by[2] += sigma_1 * (w->z - z) / h;
    return force;
}

static void learn(Memory *w, double error, const Parameters *p) {
    const double *by = w->by[delayed(w, p)];
    double square = 0.01; /* [N2] so that small derivatives do not count */
    for (int i = 0; i < LEARNED; i++)
        square += by[i] * by[i];
    for (int i = 0; i < LEARNED; i++)
        w->theta[i] *=
            elementary_exp(0.02 * clipped(p->gamma * p->rate[i] * error * by[i] / square / 0.02));
    if (w->theta[3] < w->theta[0])
        w->theta[3] = w->theta[0];
}

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    double error;
    const double v = begin_sample(w, u, p, &error);
    w->F_held = u->F_in + stepped(w, v, p, w->by[(int)w->at]);
    learn(w, error, p); /* after the force, which does not depend on u of this sample */
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .v_last = u->v_r};
    const double start[LEARNED] = {p->F_c, p->sigma_0, p->sigma_1, p->F_s, p->v_s};
    for (int i = 0; i < LEARNED; i++)
        w->theta[i] = start[i];
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
}
