/* Three models in a ring: a controller drives a mass against friction. One array each, in the order
 * of the value references; every step is an explicit Euler step of h seconds. */
#ifndef RING_H
#define RING_H

/* Controller: measured y, force u, integral part, reference, K_p, K_i. */
#define CONTROLLER_START {0.0, 0.0, 0.0, 0.2, 40.0, 900.0}
/* Mass: force u, friction f, velocity v, position x, mass m, damping d. */
#define MASS_START {0.0, 0.0, 0.0, 0.0, 2.0, 0.1}
/* Friction: velocity v, force f, coefficient c, lagged velocity z. */
#define FRICTION_START {0.0, 0.0, 1.5, 0.0, 0.0, 0.0}

static inline void step_controller(double x[6], double h) {
    const double e = x[3] - x[0];
    x[2] += h * x[5] * e;
    x[1] = x[4] * e + x[2];
}

static inline void step_mass(double x[6], double h) {
    x[2] += h * (x[0] - x[1] - x[5] * x[2]) / x[4];
    x[3] += h * x[2];
}

static inline void step_friction(double x[6], double h) {
    x[3] += h * (x[0] - x[3]) * 100.0;
    x[1] = x[2] * x[3];
}

#endif
