/* Sticking and sliding with events, after Karnopp, with a band of velocity of width 0: the mass
 * stands when v is 0 exactly. In motion the step is Heun's method on the branch of the velocity's
 * sign. Where v crosses 0 inside a sub-step, it is set to 0 at that time, and the mass leaves only
 * if the driving force is larger than F_s. */
#include "plants/motion.h"

static const double SUBSTEP = 5e-5;     /* [s] */
static const double MAX_SUBSTEPS = 1e7; /* in one step: seconds of work */

/* Slide for up to h [s] under force u [N]; returns the time that is left when v crosses 0. */
static double slide(double h, Motion *motion, double u, const Mass *mass, const Law *law) {
    static const LawState free = {0};
    const double v = motion->v, sign = v < 0.0 ? -1.0 : 1.0;
    const double first = (u - law_force(v, &free, law) - mass->b * v) * mass->per_m;
    double guess = v + h * first;
    if (guess * sign < 0.0)
        guess = sign * 1e-300; /* the end of this branch */
    const double last = (u - law_force(guess, &free, law) - mass->b * guess) * mass->per_m;
    const double a = 0.5 * (first + last); /* [m/s2] */
    const double end = v + h * a;
    if (end * sign > 0.0) {
        motion->x += 0.5 * h * (v + end);
        motion->v = end;
        return 0.0;
    }
    const double crossing = -v / a; /* [s] */
    motion->x += 0.5 * crossing * v;
    motion->v = 0.0;
    return h - crossing;
}

/* Stand, or leave, for h [s]. */
static void stand(double h, Motion *motion, LawState *state, double u, const Mass *mass,
                  const Law *law) {
    state->F_h = u;
    if (absolute(u) <= law->F_s)
        return;
    const double sign = u < 0.0 ? -1.0 : 1.0;
    motion->v = h * (u - sign * law->F_s) * mass->per_m / (1.0 + h * mass->b * mass->per_m);
    motion->x += 0.5 * h * motion->v;
}

bool motion_step(double h, Motion *motion, LawState *state, const Mass *mass, const Law *law,
                 double *dt) {
    if (!(h < MAX_SUBSTEPS * SUBSTEP))
        return false;
    const int count = h > SUBSTEP ? (int)(h / SUBSTEP + 1.0 - 1e-6) : 1;
    const double step = h / count;
    Law here = *law;
    for (int n = 0; n < count; n++) {
        const double middle = motion->x + 0.5 * step * motion->v;
        const double u = mass->u + (mass->ripples ? plant_ripple(middle, mass) : 0.0);
        const double direction = motion->v != 0.0 ? motion->v : u;
        if (mass->rough)
            here = law_scaled(law, plant_roughness(middle, direction, mass));
        double left = step;
        if (motion->v != 0.0)
            left = slide(step, motion, u, mass, &here);
        if (left > 0.0)
            stand(left, motion, state, u, mass, &here);
        if (motion->v != 0.0)
            state->F_h = 0.0;
    }
    *dt = step;
    return motion->v - motion->v == 0.0; /* finite */
}
