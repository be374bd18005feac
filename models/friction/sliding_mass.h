/* A mass on a LuGre contact: m dv/dt + b v + F_f = u, dx/dt = v, with (2) for the bristle.
 *
 * Bristle and velocity are stiff together: sigma_0 |v| / g(v) spans three decades while a search
 * varies the parameters. The step is Rodas3 (Sandu et al., Atmospheric Environment 31, 1997): a
 * Rosenbrock method of order 3 with an error estimate of order 2, stiffly accurate and L-stable,
 * so it needs no iteration and holds for every parameter vector.
 */
#ifndef SLIDING_MASS_H
#define SLIDING_MASS_H

#include <stdbool.h>

#include "friction/lugre.h"

typedef struct {
    double x; /* [m]   position */
    double v; /* [m/s] velocity */
    double z; /* [m]   bristle deflection */
} Motion;

typedef struct {
    double per_m; /* [1/kg]  1 / mass */
    double b;     /* [N s/m] viscous friction */
    double u;     /* [N]     driving force */
    LuGre contact;
    /* Further driving force [N] near position x; NULL: none. */
    double (*ripple)(double x, const void *context);
    /* Factor on g(v) near x in the direction of v; NULL: 1. */
    double (*roughness)(double x, double v, const void *context);
    const void *context;
} SlidingMass;

/* Advance by h seconds. *dt [s] holds the sub-step between calls; 0 lets the method choose.
 * Returns false when no sub-step down to 1e-12 h meets the tolerance (a value is not finite). */
bool sliding_mass_step(double h, Motion *motion, const SlidingMass *mass, double *dt);

#endif
