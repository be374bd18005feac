/* A mass on a contact: m dv/dt + b v + F_f = u, dx/dt = v, with F_f of a friction law.
 *
 * midpoint.c solves it for any law whose force is a function of v and the law's states. A law that
 * needs another method brings its own motion.c; that of a law with one bristle is in rodas3.h.
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
    double level; /* [1]     factor on the friction everywhere, where the guide is rough */
    bool ripples; /* whether plant_ripple adds to the driving force */
    bool rough;   /* whether plant_roughness scales the friction */
    const Parameters *p;
} Mass;

/* Of the plant: further driving force [N] near position x, and factor on the friction near x in the
 * direction of v. */
double plant_ripple(double x, const Mass *mass);
double plant_roughness(double x, double v, const Mass *mass);

/* Advance by h seconds. *dt [s] holds the sub-step between calls; 0 lets the method choose.
 * Returns false when the result would not be finite or the step would take minutes. */
bool motion_step(double h, Motion *motion, LawState *state, const Mass *mass, const Law *law,
                 double *dt);

#endif
