/* The force of position [N]: a constant weight, that of an arm, and harmonics of a pitch. The
 * weight of the arm loads gears and bearings, which adds to friction. */
#ifndef POSITION_FORCE_H
#define POSITION_FORCE_H

#include "numerics/elementary.h"
#include "variables.h"

static const double WHOLE_TURN = 6.283185307179586; /* [rad] */

enum { HARMONICS = 3 };

/* a sin(2 pi y) + b cos(2 pi y) */
static inline double wave(double a, double b, double y) {
    const double angle = WHOLE_TURN * (y - nearest(y));
    return a * elementary_sin(angle) + b * elementary_sin(angle + 0.25 * WHOLE_TURN);
}

static inline double arm_weight(double x, const Parameters *p) {
    return wave(p->g_s, p->g_c, x / WHOLE_TURN);
}

/* What its size adds to F_c [N]. */
static inline double friction_of_weight(double x, const Parameters *p) {
    const double weight = p->mu_g != 0.0 ? arm_weight(x, p) : 0.0;
    return p->mu_g * (weight < 0.0 ? -weight : weight);
}

static inline double position_force(double x, const Parameters *p) {
    double F = p->F_0 + arm_weight(x, p);
    for (int k = 0; k < HARMONICS; k++)
        F += wave(p->cogging_s[k], p->cogging_c[k], (double)(k + 1) * x / p->pitch);
    return F;
}

/* Whether there is any. */
static inline bool has_position_force(const Parameters *p) {
    bool any = p->F_0 != 0.0 || p->g_s != 0.0 || p->g_c != 0.0;
    for (int k = 0; k < HARMONICS; k++)
        any = any || p->cogging_s[k] != 0.0 || p->cogging_c[k] != 0.0;
    return any;
}

#endif
