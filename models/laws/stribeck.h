/* The Stribeck curve g(v) = F_c + (F_s - F_c) exp(-(|v| / v_s)^delta) [N]. */
#ifndef STRIBECK_H
#define STRIBECK_H

#include "numerics/elementary.h"

/* (|v| / v_s)^delta */
static inline double stribeck_power(double v, double v_s, double delta) {
    const double ratio = (v < 0.0 ? -v : v) / v_s;
    return delta == 1.0     ? ratio
           : delta == 2.0   ? ratio * ratio
           : ratio < 1e-300 ? 0.0
                            : elementary_exp(delta * elementary_log(ratio));
}

static inline double stribeck_curve(double v, double F_s, double F_c, double v_s, double delta) {
    return F_c + (F_s - F_c) * elementary_exp(-stribeck_power(v, v_s, delta));
}

/* |v| dg/d|v| [N] */
static inline double stribeck_slope(double v, double F_s, double F_c, double v_s, double delta) {
    const double exponent = stribeck_power(v, v_s, delta);
    return -(F_s - F_c) * delta * exponent * elementary_exp(-exponent);
}

#endif
