#ifndef ELASTO_PLASTIC_H
#define ELASTO_PLASTIC_H

#include "laws/law.h"

/* -1 or 1 */
static inline double side_of(double v) { return v < 0.0 ? -1.0 : 1.0; }

/* dz/dt [m/s] where the contact goes to a side and steady friction is `scale` times as large.
 * Its derivatives by v [1] and by z [1/s] are written. */
double elasto_plastic_dz(double v, double side, double z, double scale, const Law *p, double *by_v,
                         double *by_z);

#endif
