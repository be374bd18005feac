#include "numerics/feedback_learning.h"
#include "numerics/since_reversal.h"

enum { KNOTS = 14 };

/* Place of a displacement among the knots 0, first, ..., last: the number of the knot below and the
 * share of the way to the next. */
static double place_of(double q, const Parameters *p) {
    const double ratio = elementary_exp(elementary_log(p->last / p->first) / (double)(KNOTS - 2));
    double below = 0.0, above = p->first;
    int i = 0;
    for (; i < KNOTS - 2 && q >= above; i++) {
        below = above;
        above *= ratio;
    }
    return (double)i + clipped((q - below) / (above - below));
}

static void learn(Memory *w, double error, const Parameters *p) {
    const int old = delayed(w, p);
    if (w->row[old] == 0.0)
        return;
    double *row = w->w[w->row[old] > 0.0 ? 0 : 1];
    const int i = (int)w->knot[old] < KNOTS - 1 ? (int)w->knot[old] : KNOTS - 2;
    const double next = w->knot[old] - (double)i;
    const double share[2] = {1.0 - next, next};
    const double step = p->gamma * error / (share[0] * share[0] + next * next);
    for (int j = 0; j < 2; j++)
        row[i + j] = limited(row[i + j] + step * share[j], p->F_max);
}

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    double error;
    const double v = begin_sample(w, u, p, &error);
    const double place = place_of(since_reversal(w, v, p), p);
    const double *row = w->w[w->direction > 0.0 ? 0 : 1];
    const int i = (int)place < KNOTS - 1 ? (int)place : KNOTS - 2;
    const double force = row[i] + (place - (double)i) * (row[i + 1] - row[i]);
    w->F_held = u->F_in + (w->direction != 0.0 ? force : 0.0);

    w->row[(int)w->at] = w->direction;
    w->knot[(int)w->at] = place;
    learn(w, error, p); /* after the force, which does not depend on u of this sample */
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .v_last = u->v_r};
    for (int i = 0; i < KNOTS; i++) {
        w->w[0][i] = p->w_0[0][i];
        w->w[1][i] = p->w_0[1][i];
    }
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
}
