/* The LuGre bristle, equations (2) to (4) of the paper.
 *
 *   dz/dt = v - |v| / g(v) sigma_0 z                            (2)
 *   F_f   = sigma_0 z + sigma_1 dz/dt                           (3), v_d = 0 in the paper
 *           where sigma_1 is sigma_1 exp(-(v / v_d)^2) for v_d > 0
 *   g(v)  = F_c + (F_s - F_c) exp(-(|v| / v_s)^delta)           (4), delta = 1 in the paper
 */
#ifndef LUGRE_H
#define LUGRE_H

typedef struct {
    double F_s;     /* [N]     static friction */
    double F_c;     /* [N]     Coulomb force */
    double per_v_s; /* [s/m]   1 / v_s, the Stribeck velocity */
    double sigma_0; /* [N/m]   bristle stiffness */
    double sigma_1; /* [N s/m] bristle damping */
    double delta;   /* [1]     exponent of (4) */
    double v_d;     /* [m/s]   velocity at which the damping fades; 0: it does not */
} LuGre;

/* The contact of a model whose parameters carry these names. */
#define LUGRE_OF(p)                                                                                \
    ((LuGre){(p)->F_s, (p)->F_c, 1.0 / (p)->v_s, (p)->sigma_0, (p)->sigma_1, (p)->delta, (p)->v_d})

/* (4) [N]. If slope is not NULL it receives |v| dg/d|v| [N]. */
double lugre_g(double v, const LuGre *p, double *slope);

/* (2) [m/s] */
double lugre_dz(double v, double z, const LuGre *p);

/* Partial derivatives of (2) by v [1] and by z [1/s]. At v = 0, where |v| has a kink, the mean of
 * those on either side. */
void lugre_slopes(double v, double z, const LuGre *p, double *by_v, double *by_z);

/* sigma_1 at v [N s/m]. If slope is not NULL it receives its derivative by v [N (s/m)^2]. */
double lugre_damping(double v, const LuGre *p, double *slope);

/* (3) [N] */
double lugre_force(double v, double z, const LuGre *p);

/* Go h seconds at constant v: (2) is linear in z then, and this is its exact solution.
 * Returns the mean of (3) over the step [N]; *z [m] is the deflection before and after. */
double lugre_step(double h, double v, double *z, const LuGre *p);

/* The same with `injected` [m/s] subtracted from (2), as an observer's correction is; the damping
 * sigma_1 dz/dt feels the share `damped` [1] of it. */
double lugre_observed(double h, double v, double injected, double damped, double *z,
                      const LuGre *p);

#endif
