#include "model.h"

#include "friction/sliding_mass.h"
#include "numerics/elementary.h"
#include "numerics/noise.h"

static const double TWO_PI = 6.283185307179586;

/* The motor while the command is held: F(t) = target + (start - target) e^(-t / tau). */
typedef struct {
    double start, target; /* [N] */
    double tau;           /* [s], 0: no lag */
    const Parameters *p;
} Motor;

static double decay(double t, const Motor *motor) {
    return motor->tau > 0.0 ? elementary_exp(-t / motor->tau) : 0.0;
}

static double mean_force(double t, double dt, double x, const void *context) {
    const Motor *motor = context;
    const Parameters *p = motor->p;
    double force = motor->target;
    if (motor->tau > 0.0)
        force += (motor->start - motor->target) * decay(t, motor) * elementary_phi(dt / motor->tau);
    if (p->ripple != 0.0)
        force += p->ripple_amplitude * elementary_sin(TWO_PI * x / p->ripple_period);
    return force;
}

static double unevenness(double x, double v, const Parameters *p) {
    double factor = 1.0;
    if (p->asymmetric != 0.0)
        factor += v < 0.0 ? -p->asymmetry : p->asymmetry;
    if (p->position_dependent != 0.0)
        factor *= 1.0 + p->position_amplitude * elementary_sin(TWO_PI * x / p->position_period);
    return factor;
}

static double roughness(double x, double v, const void *context) {
    return unevenness(x, v, ((const Motor *)context)->p);
}

static double quantised(double value, double step) { return nearest(value / step) * step; }

/* Force command as the amplifier takes it: DAC steps, then the limit. */
static double amplified(double u, const Parameters *p) {
    if (p->dac != 0.0)
        u = quantised(u, p->dac_step);
    return u > p->u_max ? p->u_max : u < -p->u_max ? -p->u_max : u;
}

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){0};
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const double tau = p->current_loop != 0.0 ? p->tau_i : 0.0;
    const Motor motor = {w->F_motor, amplified(u->u, p), tau, p};
    const SlidingMass mass = {p->m, p->b, LUGRE_OF(p), mean_force, roughness, &motor};
    Motion motion = {x->x, x->v, x->z};
    if (!sliding_mass_step(h, &motion, &mass, &w->dt))
        return false;
    *x = (States){motion.x, motion.v, motion.z};
    w->F_motor = motor.target + (motor.start - motor.target) * decay(h, &motor);
    w->n += 1.0;
    return true;
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->x_enc = x->x;
    y->F_m = w->F_motor;
    LuGre contact = LUGRE_OF(p);
    const double factor = unevenness(x->x, x->v, p);
    contact.F_s *= factor;
    contact.F_c *= factor;
    y->F_f = lugre_force(x->v, x->z, &contact);
    if (p->noise != 0.0) {
        y->x_enc += p->noise_x * noise_draw(p->seed, 0, w->n);
        y->F_m += p->noise_F * noise_draw(p->seed, 1, w->n);
    }
    if (p->encoder != 0.0)
        y->x_enc = quantised(y->x_enc, p->encoder_step);
}
