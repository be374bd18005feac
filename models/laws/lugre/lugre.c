#include "laws/lugre/lugre.h"

#include <stdbool.h>
#include <stddef.h>

#include "numerics/elementary.h"

/* (|v| / v_s)^delta */
static double stribeck_exponent(double v, const LuGre *p) {
    const double ratio = (v < 0.0 ? -v : v) * p->per_v_s;
    if (p->delta == 1.0)
        return ratio;
    if (p->delta == 2.0)
        return ratio * ratio;
    return ratio < 1e-300 ? 0.0 : elementary_exp(p->delta * elementary_log(ratio));
}

/* a(v) = sigma_0 |v| / g(v) [1/s], the rate at which the bristle forgets */
static double forgetting_rate(double v, const LuGre *p) {
    return p->sigma_0 * (v < 0.0 ? -v : v) / lugre_g(v, p, NULL);
}

double lugre_g(double v, const LuGre *p, double *slope) {
    const double exponent = stribeck_exponent(v, p);
    /* Beyond 40 g is F_c to the last bit: 9 e^-40 < 2^-54. */
    const bool faded = exponent > 40.0 && p->F_s < 10.0 * p->F_c;
    const double stribeck = faded ? 0.0 : (p->F_s - p->F_c) * elementary_exp(-exponent);
    if (slope != NULL)
        *slope = -stribeck * p->delta * exponent;
    return p->F_c + stribeck;
}

double lugre_dz(double v, double z, const LuGre *p) { return v - forgetting_rate(v, p) * z; }

void lugre_slopes(double v, double z, const LuGre *p, double *by_v, double *by_z) {
    double slope;
    const double g = lugre_g(v, p, &slope);
    const double sign = v > 0.0 ? 1.0 : v < 0.0 ? -1.0 : 0.0;
    *by_v = 1.0 - p->sigma_0 * z * sign * (g - slope) / (g * g);
    *by_z = -forgetting_rate(v, p);
}

double lugre_damping(double v, const LuGre *p, double *slope) {
    const double ratio = p->v_d > 0.0 ? v / p->v_d : 0.0;
    const double damping = p->v_d > 0.0 ? p->sigma_1 * elementary_exp(-ratio * ratio) : p->sigma_1;
    if (slope != NULL)
        *slope = p->v_d > 0.0 ? -2.0 * ratio / p->v_d * damping : 0.0;
    return damping;
}

double lugre_force(double v, double z, const LuGre *p) {
    return p->sigma_0 * z + lugre_damping(v, p, NULL) * lugre_dz(v, z, p);
}

double lugre_step(double h, double v, double *z, const LuGre *p) {
    return lugre_observed(h, v, 0.0, 0.0, z, p);
}

double lugre_observed(double h, double v, double injected, double damped, double *z,
                      const LuGre *p) {
    const double a = forgetting_rate(v, p);
    const double dz = v - injected - a * *z;
    const double way = h * elementary_phi(a * h) * dz;
    const double mean_z = *z + h * elementary_phi2(a * h) * dz;
    const double sigma_1 = lugre_damping(v, p, NULL);
    *z += way;
    return p->sigma_0 * mean_z + sigma_1 * way / h + sigma_1 * (1.0 - damped) * injected;
}
