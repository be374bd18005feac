/* A learning network of velocity and displacement since the last reversal: what a model.c with the
 * variables of network.toml includes after its functions force_of(w, place, p), the force at a
 * place, and learn(w, place, error, p), which corrects the weights. */
#include "numerics/feedback_learning.h"
#include "numerics/since_reversal.h"

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    double error;
    const double v = begin_sample(w, u, p, &error), speed = v < 0.0 ? -v : v;
    const double q = since_reversal(w, v, p);
    double *place = w->place[(int)w->at];
    place[0] = w->direction * clipped(elementary_log(1.0 + speed / p->v_0) /
                                      elementary_log(1.0 + p->v_max / p->v_0));
    place[1] = w->direction * (2.0 * q / (q + p->q_0) - 1.0);
    w->F_held = u->F_in + (w->direction != 0.0 ? force_of(w, place, p) : 0.0);
    const double *before = w->place[delayed(w, p)];
    if (before[0] != 0.0 || before[1] != 0.0) /* there was motion */
        learn(w, before, error, p); /* after the force, which does not depend on u of this sample */
}

#include "numerics/sampled.h"

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
}
