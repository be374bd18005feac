/* A mass on a contact: m dv/dt + b v + F_f = u, dx/dt = v, with F_f of a friction law.
 *
 * midpoint.c solves it for any law whose force is a function of v and the law's states. A law that
 * needs another method brings its own motion.c.
 */
#ifndef MOTION_H
#define MOTION_H

#include <stdbool.h>

#include "laws/law.h"

typedef struct {
    double x; /* [m]   position */
    double v; /* [m/s] velocity */
} Motion;

typedef struct {
    double per_m; /* [1/kg]  1 / mass */
    double b;     /* [N s/m] viscous friction */
    double u;     /* [N]     driving force */
    /* Further driving force [N] near position x; NULL: none. */
    double (*ripple)(double x, const void *context);
    /* Factor on the friction near x in the direction of v; NULL: 1. */
    double (*roughness)(double x, double v, const void *context);
    const void *context;
} Mass;

/* Advance by h seconds. *dt [s] holds the sub-step between calls; 0 lets the method choose.
 * Returns false when the result would not be finite or the step would take minutes. */
bool motion_step(double h, Motion *motion, LawState *state, const Mass *mass, const Law *law,
                 double *dt);

#endif
