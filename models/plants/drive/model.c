#include "model.h"

#include <stddef.h>

#include "numerics/elementary.h"
#include "numerics/noise.h"
#include "numerics/position_force.h"
#include "plants/motion.h"

static const double TWO_PI = 6.283185307179586;

/* Factor by which friction has fallen at time t as the guide gets warm. */
static double level(double t, const Parameters *p) {
    const double cold = elementary_exp(t > 0.0 ? -t / p->drift_time : 0.0);
    return 1.0 - p->drift * (1.0 - cold);
}

double plant_roughness(double x, double v, const Mass *mass) {
    const Parameters *p = mass->p;
    double factor = 1.0;
    if (p->asymmetric != 0.0)
        factor += v < 0.0 ? -p->asymmetry : p->asymmetry;
    if (p->position_dependent != 0.0)
        factor *= 1.0 + p->position_amplitude * elementary_sin(TWO_PI * x / p->position_period);
    const double load = p->load < 0.0 ? -p->load : p->load;
    const double more = p->mu * load + friction_of_weight(x, p);
    return factor * (mass->level * (1.0 + more / p->F_c));
}

static bool is_rough(const Parameters *p) {
    return p->asymmetric != 0.0 || p->position_dependent != 0.0 || p->drift != 0.0 ||
           p->load != 0.0 || p->mu_g != 0.0;
}

double plant_ripple(double x, const Mass *mass) {
    const Parameters *p = mass->p;
    double F = 0.0;
    if (p->ripple != 0.0)
        F = p->ripple_amplitude * elementary_sin(TWO_PI * x / p->ripple_period);
    return has_position_force(p) ? F - position_force(x, p) : F;
}

static double quantised(double value, double step) { return nearest(value / step) * step; }

/* Force command as the amplifier takes it: DAC steps, then the limit. */
static double amplified(double u, const Parameters *p) {
    if (p->dac != 0.0)
        u = quantised(u, p->dac_step);
    return limited(u, p->u_max);
}

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){0};
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    Mass mass = {
        .per_m = 1.0 / p->m,
        .b = p->b,
        .level = level(t + 0.5 * h, p),
        .ripples = p->ripple != 0.0 || has_position_force(p),
        .rough = is_rough(p),
        .p = p,
    };
    Motion motion = {x->x, x->v};
    const double target = amplified(u->u, p);
    double lagging = 0.0; /* [s] */
    if (p->current_loop != 0.0) {
        /* F(t) = target + gap e^(-t / tau_i). A constant force for a part of the step and then the
         * target have the same impulse and move the mass as far. */
        const double gap = w->F_motor - target;
        const double y = h / p->tau_i;
        const double mean = elementary_phi(y);
        const double left = 1.0 - y * mean; /* e^-y */
        lagging = 2.0 * p->tau_i * (1.0 - left / mean);
        mass.u = target + gap * mean * h / lagging;
        if (!motion_step(lagging, &motion, x, &mass, p, &w->dt))
            return false;
        w->F_motor = target + gap * left;
    } else {
        w->F_motor = target;
    }
    mass.u = target;
    if (!motion_step(h - lagging, &motion, x, &mass, p, &w->dt))
        return false;
    x->x = motion.x;
    x->v = motion.v;
    w->n += 1.0;
    return true;
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->x_enc = x->x + p->sde * elementary_sin(TWO_PI * x->x / p->sde_period);
    y->F_m = w->F_motor;
    if (is_rough(p)) {
        const Mass guide = {.level = level(t, p), .p = p};
        const Law here = law_scaled(p, plant_roughness(x->x, x->v, &guide));
        y->F_f = law_force(x->v, x, &here);
    } else {
        y->F_f = law_force(x->v, x, p);
    }
    if (p->noise != 0.0) {
        y->x_enc += p->noise_x * noise_draw(p->seed, 0, w->n);
        y->F_m += p->noise_F * noise_draw(p->seed, 1, w->n);
    }
    if (p->encoder != 0.0)
        y->x_enc = quantised(y->x_enc, p->encoder_step);
}
