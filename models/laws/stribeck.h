/* The Stribeck curve g(v) = F_c + (F_s - F_c) exp(-(|v| / v_s)^delta) [N]. */
#ifndef STRIBECK_H
#define STRIBECK_H

#include "numerics/elementary.h"

static inline double stribeck_curve(double v, double F_s, double F_c, double v_s, double delta) {
    const double ratio = (v < 0.0 ? -v : v) / v_s;
    const double exponent = delta == 1.0     ? ratio
                            : delta == 2.0   ? ratio * ratio
                            : ratio < 1e-300 ? 0.0
                                             : elementary_exp(delta * elementary_log(ratio));
    return F_c + (F_s - F_c) * elementary_exp(-exponent);
}

#endif
