#include "model.h"

#include "numerics/elementary.h"

/* An integral after this sample. Anti-windup: it stands still while the error would push the force
 * further past its limit. */
static double integrated(double before, double after, double error, double demanded, double u) {
    return demanded == u || (demanded > 0.0) != (error > 0.0) ? after : before;
}

/* Damping of composite nonlinear feedback [N s/m]: from 0 to gamma_v while the position error falls
 * from e_0, its size when the command last changed, to 0. */
static double damping(Memory *w, double x_cmd, double e_x, const Parameters *p) {
    const double size = e_x < 0.0 ? -e_x : e_x;
    if (x_cmd != w->x_cmd_last)
        w->e_0 = size;
    w->x_cmd_last = x_cmd;
    if (p->gamma_v == 0.0 || size == 0.0 || w->e_0 == 0.0)
        return p->gamma_v;
    const double least = elementary_exp(-p->alpha), share = size < w->e_0 ? size / w->e_0 : 1.0;
    return p->gamma_v * (elementary_exp(-p->alpha * share) - least) / (1.0 - least);
}

/* One sample: estimate, PI of position and of velocity, feedforward, limit. */
static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    /* v+ = v + (1 - e^(-T_s / tau_f)) (dx / T_s - v)   [m/s] */
    const double weight = p->tau_f > 0.0 ? 1.0 - elementary_exp(-p->T_s / p->tau_f) : 1.0;
    w->v_filtered += weight * ((u->x_enc - w->x_last) / p->T_s - w->v_filtered);
    w->x_last = u->x_enc;
    const double v = p->use_v_hat != 0.0 ? u->v_hat : w->v_filtered;

    /* e_x = x_cmd - x_enc [m],   e_v = velocity_feedforward v_cmd + K_x e_x - v [m/s] */
    const double e_x = u->x_cmd - u->x_enc;
    const double e_v = p->velocity_feedforward * u->v_cmd + p->K_x * e_x - v;

    /* u = K_p e_v + I + F_ff + m_ff a_cmd + P_x e_x + J + gamma_v rho(e_x) (v_cmd - v)   [N] */
    const double I = w->I + p->T_s * p->K_i * e_v;
    const double J = w->J + p->T_s * p->I_x * e_x;
    const double feedforward = u->F_ff + p->m_ff * u->a_cmd;
    const double damped = damping(w, u->x_cmd, e_x, p) * (u->v_cmd - v);
    const double demanded = p->K_p * e_v + I + feedforward + (p->P_x * e_x + J) + damped;
    w->u_held = limited(demanded, p->u_max);
    w->I = integrated(w->I, I, e_v, demanded, w->u_held);
    w->J = integrated(w->J, J, e_x, demanded, w->u_held);
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .x_last = u->x_enc, .x_cmd_last = u->x_cmd};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->u = w->u_held;
    y->v_est = w->v_filtered;
}
