#include "numerics/feedback_learning.h"
#include "numerics/since_reversal.h"

enum { SPEEDS = 11 };

enum { WAYS = 8 };

/* Shares of n Gaussian functions with centres from -1 to 1; returns the sum of their squares. */
static double shares(double *share, int n, double place, double width) {
    const double per_distance = 0.5 * (double)(n - 1) / width;
    double sum = 0.0, square = 0.0;
    for (int i = 0; i < n; i++) {
        const double x = (place - (2.0 * (double)i / (double)(n - 1) - 1.0)) * per_distance;
        share[i] = elementary_exp(-0.5 * x * x);
        sum += share[i];
    }
    for (int i = 0; i < n; i++) {
        share[i] /= sum;
        square += share[i] * share[i];
    }
    return square;
}

static double force_of(const Memory *w, const double *place, const Parameters *p) {
    double speed[SPEEDS], way[WAYS], force = 0.0;
    shares(speed, SPEEDS, place[0], p->width);
    shares(way, WAYS, place[1], p->width);
    for (int i = 0; i < SPEEDS; i++)
        for (int j = 0; j < WAYS; j++)
            force += w->w[i][j] * speed[i] * way[j];
    return force;
}

static void learn(Memory *w, double error, const Parameters *p) {
    const double *place = w->place[delayed(w, p)];
    if (place[0] == 0.0 && place[1] == 0.0)
        return; /* there was no motion yet */
    double speed[SPEEDS], way[WAYS];
    const double square = shares(speed, SPEEDS, place[0], p->width);
    const double step = p->gamma * error / (square * shares(way, WAYS, place[1], p->width));
    for (int i = 0; i < SPEEDS; i++)
        for (int j = 0; j < WAYS; j++) {
            const double trial = w->w[i][j] + step * speed[i] * way[j];
            w->w[i][j] = trial > p->F_max ? p->F_max : trial < -p->F_max ? -p->F_max : trial;
        }
}

static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    double error;
    const double v = begin_sample(w, u, p, &error), speed = v < 0.0 ? -v : v;
    const double q = since_reversal(w, v, p);
    double *place = w->place[(int)w->at];
    place[0] = w->direction * clipped(elementary_log(1.0 + speed / p->v_0) /
                                      elementary_log(1.0 + p->v_max / p->v_0));
    place[1] = w->direction * (2.0 * q / (q + p->q_0) - 1.0);
    w->F_held = u->F_in + (w->direction != 0.0 ? force_of(w, place, p) : 0.0);
    learn(w, error, p); /* after the force, which does not depend on u of this sample */
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .v_last = u->v_r};
    for (int i = 0; i < SPEEDS; i++)
        for (int j = 0; j < WAYS; j++)
            w->w[i][j] = p->w_0[i][j];
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->F = w->F_held;
}
