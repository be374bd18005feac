/* A mass on one bristle of a law, F_f = sigma_0 z + damping, with dz/dt and the damping of the law.
 *
 * Bristle and velocity are stiff together: sigma_0 |v| / g(v) spans three decades while a search
 * varies the parameters. The step is Rodas3 (Sandu et al., Atmospheric Environment 31, 1997): a
 * Rosenbrock method of order 3 with an error estimate of order 2, stiffly accurate and L-stable,
 * so it needs no iteration and holds for every parameter vector.
 */
#ifndef RODAS3_H
#define RODAS3_H

#include <stddef.h>
#include <stdint.h>

#include "plants/motion.h"

/* Local error allowed per sub-step, relative to the motion itself and absolute. */
static const double RELATIVE = 1e-6;
static const double ABSOLUTE_V = 1e-8; /* [m/s] */
static const double ABSOLUTE_F = 1e-5; /* [N], as bristle force sigma_0 z */

enum { MAX_SUBSTEPS = 10000000 }; /* in one step: seconds of work */

/* What moves; z [m] is the bristle deflection. */
typedef struct {
    double x, v, z;
} Sliding;

/* dz/dt [m/s] and the force of damping [N], and their derivatives by v and z. */
typedef struct {
    double dz, damping;
} Bristle;
typedef struct {
    double zv, zz, Fv, Fz;
} BristleSlopes;

/* Of the law, which defines it, where friction is `scale` times as large at every steady speed. */
static Bristle bristle(double v, double z, double scale, const Law *p, BristleSlopes *slopes);

/* dv/dt and dz/dt under force u, and their Jacobian in (v, z). */
typedef struct {
    double dv, dz;
} Rate;
typedef struct {
    double vv, vz, zv, zz;
} Matrix;

static Rate rate(double v, double z, double u, double scale, const Mass *s, const Law *p,
                 Matrix *jacobian) {
    BristleSlopes slopes;
    const Bristle now = bristle(v, z, scale, p, &slopes);
    if (jacobian) {
        jacobian->zv = slopes.zv;
        jacobian->zz = slopes.zz;
        jacobian->vv = -(s->b + slopes.Fv) * s->per_m;
        jacobian->vz = -(p->sigma_0 + slopes.Fz) * s->per_m;
    }
    return (Rate){(u - s->b * v - p->sigma_0 * z - now.damping) * s->per_m, now.dz};
}

/* (c I - J)^-1 */
static Matrix resolvent(double c, const Matrix *J) {
    const double vv = c - J->vv, zz = c - J->zz;
    const double scale = 1.0 / (vv * zz - J->vz * J->zv);
    return (Matrix){zz * scale, J->vz * scale, J->zv * scale, vv * scale};
}

/* One stage of the method: solve (2/h I - J) k = r by the inverse W; x follows v. */
static Sliding stage(double h, const Matrix *W, double rx, double rv, double rz) {
    Sliding k;
    k.v = W->vv * rv + W->vz * rz;
    k.z = W->zv * rv + W->zz * rz;
    k.x = (rx + k.v) * (0.5 * h);
    return k;
}

/* Trial step of Rodas3 from y; returns the scaled error of the embedded method. */
static double try_step(double h, const Sliding *y, double u, double scale, const Mass *s,
                       const Law *p, Sliding *next) {
    const double c1 = 1.0 / h, c4 = 4.0 * c1, w = 8.0 / 3.0;
    Matrix J;
    Rate f = rate(y->v, y->z, u, scale, s, p, &J);
    const Matrix W = resolvent(2.0 * c1, &J);
    const Sliding a = stage(h, &W, y->v, f.dv, f.dz);
    const Sliding b = stage(h, &W, y->v + c4 * a.x, f.dv + c4 * a.v, f.dz + c4 * a.z);
    const double v3 = y->v + 2.0 * a.v, z3 = y->z + 2.0 * a.z;
    f = rate(v3, z3, u, scale, s, p, NULL);
    const Sliding c =
        stage(h, &W, v3 + c1 * (a.x - b.x), f.dv + c1 * (a.v - b.v), f.dz + c1 * (a.z - b.z));
    const double v4 = v3 + c.v, z4 = z3 + c.z;
    f = rate(v4, z4, u, scale, s, p, NULL);
    const Sliding d = stage(h, &W, v4 + c1 * (a.x - b.x - w * c.x),
                            f.dv + c1 * (a.v - b.v - w * c.v), f.dz + c1 * (a.z - b.z - w * c.z));
    *next = (Sliding){y->x + 2.0 * a.x + c.x + d.x, v4 + d.v, z4 + d.z};
    const double error_v = absolute(d.v) / (ABSOLUTE_V + RELATIVE * absolute(next->v));
    const double error_z =
        p->sigma_0 * absolute(d.z) / (ABSOLUTE_F + RELATIVE * p->sigma_0 * absolute(next->z));
    return error_v > error_z ? error_v : error_z;
}

/* Factor on the sub-step that would bring the error to 0.5 of what is allowed, within 0.3 %:
 * 0.8 / error^(1/3). Minus a third of the bits of a number is close to this root, which one step of
 * Newton's method improves. */
static double step_factor(double error) {
    if (error < 0.004)
        return 5.0;
    if (error > 100.0)
        return 0.15;
    union {
        double value;
        uint64_t bits;
    } root = {error};
    root.bits = 0x553EF0FF289DD796u - root.bits / 3;
    const double r = root.value;
    return 0.8 / 3.0 * r * (4.0 - error * r * r * r);
}

bool motion_step(double h, Motion *motion, LawState *state, const Mass *mass, const Law *law,
                 double *dt) {
    Sliding now = {motion->x, motion->v, state->z};
    double t = 0.0;
    double trial = *dt > 0.0 && *dt < h ? *dt : h;
    for (int n = 0; t < h; n++) {
        const bool last = t + trial * 1.000001 >= h;
        const double step = last ? h - t : trial;
        const double middle = now.x + 0.5 * step * now.v;
        const double u = mass->u + (mass->ripples ? plant_ripple(middle, mass) : 0.0);
        const double scale = mass->rough ? plant_roughness(middle, now.v, mass) : 1.0;
        Sliding next;
        const double error = try_step(step, &now, u, scale, mass, law, &next);
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
        now = next;
        t = last ? h : t + step;
    }
    *dt = trial;
    *motion = (Motion){now.x, now.v};
    state->z = now.z;
    return true;
}

#endif
