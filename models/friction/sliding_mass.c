#include "friction/sliding_mass.h"

#include <stddef.h>

#include "numerics/elementary.h"

/* Local error allowed per sub-step, relative to the motion itself and absolute. */
static const double RELATIVE = 1e-6;
static const double ABSOLUTE_V = 1e-8; /* [m/s] */
static const double ABSOLUTE_F = 1e-5; /* [N], as bristle force sigma_0 z */

enum { MAX_SUBSTEPS = 10000000 }; /* in one step: seconds of work */

/* dv/dt and dz/dt under force u, and their Jacobian in (v, z). */
typedef struct {
    double dv, dz;
} Rate;
typedef struct {
    double vv, vz, zv, zz;
} Jacobian;

static double absolute(double a) { return a < 0.0 ? -a : a; }

static Rate rate(double v, double z, double u, double scale, const SlidingMass *s,
                 Jacobian *jacobian) {
    const LuGre *p = &s->contact;
    double slope;
    const double g = scale * lugre_g(v, p, &slope);
    const double speed = absolute(v);
    const double dz = v - p->sigma_0 * speed / g * z;
    if (jacobian) {
        const double sign = v < 0.0 ? -1.0 : 1.0;
        jacobian->zv = 1.0 - p->sigma_0 * z * sign * (g - scale * slope) / (g * g);
        jacobian->zz = -p->sigma_0 * speed / g;
        jacobian->vv = -(s->b + p->sigma_1 * jacobian->zv) / s->m;
        jacobian->vz = -(p->sigma_0 + p->sigma_1 * jacobian->zz) / s->m;
    }
    return (Rate){(u - s->b * v - p->sigma_0 * z - p->sigma_1 * dz) / s->m, dz};
}

/* One stage of the method: solve (2/h I - J) k = r; x follows v. */
static Motion stage(double h, const Jacobian *J, double rx, double rv, double rz) {
    const double a = 2.0 / h - J->vv, d = 2.0 / h - J->zz;
    const double determinant = a * d - J->vz * J->zv;
    Motion k;
    k.v = (rv * d + J->vz * rz) / determinant;
    k.z = (a * rz + J->zv * rv) / determinant;
    k.x = (rx + k.v) * h / 2.0;
    return k;
}

/* Trial step of Rodas3 from y; returns the scaled error of the embedded method. */
static double try_step(double h, const Motion *y, double u, double scale, const SlidingMass *s,
                       Motion *next) {
    Jacobian J;
    Rate f = rate(y->v, y->z, u, scale, s, &J);
    const Motion a = stage(h, &J, y->v, f.dv, f.dz);
    const Motion b = stage(h, &J, y->v + 4.0 / h * a.x, f.dv + 4.0 / h * a.v, f.dz + 4.0 / h * a.z);
    const double v3 = y->v + 2.0 * a.v, z3 = y->z + 2.0 * a.z;
    f = rate(v3, z3, u, scale, s, NULL);
    const Motion c =
        stage(h, &J, v3 + (a.x - b.x) / h, f.dv + (a.v - b.v) / h, f.dz + (a.z - b.z) / h);
    const double v4 = v3 + c.v, z4 = z3 + c.z;
    f = rate(v4, z4, u, scale, s, NULL);
    const double w = 8.0 / 3.0;
    const Motion d = stage(h, &J, v4 + (a.x - b.x - w * c.x) / h, f.dv + (a.v - b.v - w * c.v) / h,
                           f.dz + (a.z - b.z - w * c.z) / h);
    *next = (Motion){y->x + 2.0 * a.x + c.x + d.x, v4 + d.v, z4 + d.z};
    const double error_v = absolute(d.v) / (ABSOLUTE_V + RELATIVE * absolute(next->v));
    const double error_z = s->contact.sigma_0 * absolute(d.z) /
                           (ABSOLUTE_F + RELATIVE * s->contact.sigma_0 * absolute(next->z));
    return error_v > error_z ? error_v : error_z;
}

/* Factor on the sub-step that would bring the error to 0.5 of what is allowed. */
static double step_factor(double error) {
    if (error < 0.004)
        return 5.0;
    return error > 100.0 ? 0.15 : 0.8 * elementary_exp(elementary_log(error) / -3.0);
}

bool sliding_mass_step(double h, Motion *motion, const SlidingMass *s, double *dt) {
    double t = 0.0;
    double trial = *dt > 0.0 && *dt < h ? *dt : h;
    for (int n = 0; t < h; n++) {
        const bool last = t + trial * 1.000001 >= h;
        const double step = last ? h - t : trial;
        const double middle = motion->x + 0.5 * step * motion->v;
        const double u = s->u + (s->ripple ? s->ripple(middle, s->context) : 0.0);
        const double scale = s->roughness ? s->roughness(middle, motion->v, s->context) : 1.0;
        Motion next;
        const double error = try_step(step, motion, u, scale, s, &next);
        if (error != error || n == MAX_SUBSTEPS)
            return false;
        const double proposal = step * step_factor(error);
        if (error > 1.0) {
            if (proposal < 1e-12 * h)
                return false;
            trial = proposal;
            continue;
        }
        if (!last || proposal > trial)
            trial = proposal;
        *motion = next;
        t = last ? h : t + step;
    }
    *dt = trial;
    return true;
}
