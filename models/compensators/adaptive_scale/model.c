#include "numerics/momentum.h"
#include "numerics/since_reversal.h"

/* Least squares of the friction F_in s, with exponential forgetting. */
static void adapt(Memory *w, double error, const Parameters *p) {
    const double share = 1.0 - elementary_exp(-p->rate * p->T_s), f = w->F_last;
    w->square += w->square > 0.0 ? share * (f * f - w->square) : f * f;
    const double s = w->s + share * error * f / w->square;
    w->s = s < p->least ? p->least : s > p->most ? p->most : s;
}

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    double v;
    w->F_held = w->s * u->F_in;
    const double error = unexplained(w, u->x_enc, u->F_m, w->F_held, &v, p); /* [N] */
    const double way = w->direction * (u->x_enc - w->x_reversal);            /* [m] */
    if (w->q > p->q_min && way > 0.5 * w->q && w->direction * w->v_last > p->v_min &&
        w->direction * w->F_last > 0.0) /* it slides: the reference says so, and the encoder */
        adapt(w, error, p);             /* after the force, which does not depend on this sample */

    const double before = w->direction;
    since_reversal(w, 0.5 * (w->v_last + u->v_r), p);
    if (w->direction != before)
        w->x_reversal = u->x_enc;
    w->v_last = u->v_r;
    w->F_last = u->F_in;
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const double s = p->s_0;
    *w = (Memory){.k = first_sample(t, p->T_s),
                  .x_last = u->x_enc,
                  .N_last = u->F_m - p->F_0,
                  .N_before = 0.5 * (u->F_m - p->F_0),
                  .N = u->F_m - p->F_0,
                  .s = s < p->least  ? p->least
                       : s > p->most ? p->most
                                     : s,
                  .v_last = u->v_r};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
}
