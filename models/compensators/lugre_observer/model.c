#include "model.h"
#include "laws/lugre/lugre.h"
#include "numerics/elementary.h"

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    const double weight = p->tau_f > 0.0 ? 1.0 - elementary_exp(-p->T_s / p->tau_f) : 1.0;
    w->v += weight * ((u->x_enc - w->x_last) / p->T_s - w->v);
    w->x_last = u->x_enc;
    const double error = w->v - w->v_last; /* v_r belongs to the end of the period [m/s] */
    const double slope = (u->v_r - w->v_last) / p->T_s; /* [m/s2] */
    const double early = 0.5 * (w->v_last + u->v_r) + p->lead * slope;
    w->v_last = u->v_r;

    const LuGre contact = LUGRE_OF(p);
    const double v = p->reference != 0.0 ? early : w->v;
    w->F_held = u->F_in + lugre_observed(p->T_s, v, p->k_e * error, p->share_1, &w->z, &contact);

    /* The model alone stays within F_s / sigma_0; the correction of a drive that is held would not
     * end. */
    const double most = 3.0 * p->F_s / p->sigma_0; /* [m] */
    w->z = w->z > most ? most : w->z < -most ? -most : w->z;
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .x_last = u->x_enc, .v_last = u->v_r};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
    y->z_hat = w->z;
}
