#include "model.h"

#include "numerics/axis_filter.h"
#include "numerics/sampling.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .x = u->x_enc, .N_last = u->F_m};
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    if (!samples_countable(w->k, p->T_s, t + h))
        return false;
    for (; sample_due(w->k, p->T_s, t + h); w->k += 1.0)
        axis_sample(w, u->x_enc, u->F_m, u->F_in, p);
    const double all = w->x + w->v + w->d + w->N_last + w->F_known;
    return all - all == 0.0; /* finite */
}

double model_sample(double t, Memory *w, const Inputs *u, const Parameters *p) {
    for (; samples_countable(w->k, p->T_s, t) && sample_reached(w->k, p->T_s, t); w->k += 1.0)
        axis_sample(w, u->x_enc, u->F_m, u->F_in, p);
    return w->k * p->T_s;
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_next - p->share * w->d;
    y->d_hat = w->d;
}
