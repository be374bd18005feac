/* The implicit midpoint rule with one unknown, the mean velocity w of a sub-step:
 *
 *   r(w) = 2 m (w - v) / h + b w + F_mean(w) - u = 0,    v <- 2 w - v,    x <- x + h w
 *
 * F_mean is the law's mean force over the sub-step at constant w, so that the method needs neither
 * the law's derivatives nor its events. r grows with w, and its root is unique, where 2 m / h + b
 * is more than the steepest fall of the Stribeck curve.
 */
#include "plants/motion.h"

static const double SUBSTEP = 5e-5;   /* [s] */
static const double RESIDUAL = 1e-10; /* [N] */
static const double STANDING = 1e-15; /* [m/s] */
static const double ROUNDING = 1e-14; /* of the forces in r, and of v */

static const double MAX_SUBSTEPS = 1e7; /* in one step: seconds of work */

enum { MAX_ITERATIONS = 200 };

typedef struct {
    double h, v;           /* [s], [m/s] length and first velocity of the sub-step */
    double u;              /* [N] driving force */
    double per_m, b;       /* [1/kg], [N s/m] */
    const LawState *state; /* at its beginning */
    const Law *law;
} Substep;

/* What the last sub-step showed and the next one starts from. */
typedef struct {
    double gain;  /* [m/s] w - v */
    double slope; /* [N s/m] of r */
} Trend;

/* r(w) [N]; *end is the law's state after the sub-step. */
static double residual(double w, const Substep *s, LawState *end) {
    *end = *s->state;
    return 2.0 * (w - s->v) / (s->h * s->per_m) + s->b * w + law_step(s->h, w, end, s->law) - s->u;
}

/* Find the root of r by one step of Newton's method along the trend, and if that does not do, by
 * regula falsi with Illinois' weights, from a bracket that grows. Returns false when there is none.
 */
static bool solve(const Substep *s, Trend *trend, double *w, LawState *end) {
    const double inertia = 2.0 * absolute(s->v) / (s->h * s->per_m);
    const double small = RESIDUAL + ROUNDING * (inertia + absolute(s->u));
    double w0 = s->v + trend->gain, r0 = residual(w0, s, end);
    *w = w0;
    if (absolute(r0) < small)
        return true;
    double reach = -r0 / trend->slope;
    double w1 = w0 + reach, r1 = residual(w1, s, end);
    if ((r1 - r0) * reach > 0.0)
        trend->slope = (r1 - r0) / reach;
    for (int n = 0; (r0 > 0.0) == (r1 > 0.0) && !(absolute(r1) < small) && n < MAX_ITERATIONS;
         n++) {
        reach *= 2.0;
        w0 = w1, r0 = r1;
        w1 += reach, r1 = residual(w1, s, end);
    }
    *w = w1;
    double r = r1;
    for (int n = 0; !(absolute(r) < small) && n < MAX_ITERATIONS; n++) {
        *w = w1 - r1 * (w1 - w0) / (r1 - r0);
        r = residual(*w, s, end);
        if ((r > 0.0) != (r1 > 0.0))
            w0 = w1, r0 = r1;
        else
            r0 *= 0.5;
        w1 = *w, r1 = r;
        /* The force of a contact that comes to a stand may jump at w = 0. */
        if (absolute(w1 - w0) < STANDING + ROUNDING * absolute(s->v))
            return true;
    }
    return absolute(r) < small;
}

bool motion_step(double h, Motion *motion, LawState *state, const Mass *mass, const Law *law,
                 double *dt) {
    if (!(h < MAX_SUBSTEPS * SUBSTEP))
        return false;
    const int count = h > SUBSTEP ? (int)(h / SUBSTEP + 1.0 - 1e-6) : 1;
    const double step = h / count;
    Law here = *law;
    Trend trend = {0.0, 2.0 / (step * mass->per_m) + mass->b};
    for (int n = 0; n < count; n++) {
        const double middle = motion->x + 0.5 * step * motion->v;
        const double u = mass->u + (mass->ripples ? plant_ripple(middle, mass) : 0.0);
        if (mass->rough)
            here = law_scaled(law, plant_roughness(middle, motion->v, mass));
        const LawState begin = *state;
        const Substep s = {step, motion->v, u, mass->per_m, mass->b, &begin, &here};
        double w;
        if (!solve(&s, &trend, &w, state))
            return false;
        trend.gain = w - motion->v;
        motion->x += step * w;
        motion->v = 2.0 * w - motion->v;
    }
    *dt = step;
    return true;
}
