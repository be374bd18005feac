#include "numerics/elementary.h"
#include "variables.h"

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

static void learn(Memory *w, const double *place, double error, const Parameters *p) {
    double speed[SPEEDS], way[WAYS];
    const double square = shares(speed, SPEEDS, place[0], p->width);
    const double step = p->gamma * error / (square * shares(way, WAYS, place[1], p->width));
    for (int i = 0; i < SPEEDS; i++)
        for (int j = 0; j < WAYS; j++)
            w->w[i][j] = limited(w->w[i][j] + step * speed[i] * way[j], p->F_max);
}

#include "numerics/network.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .v_last = u->v_r};
    for (int i = 0; i < SPEEDS; i++)
        for (int j = 0; j < WAYS; j++)
            w->w[i][j] = p->w_0[i][j];
}
