#include "model.h"

enum { ORDER = sizeof(((Memory *)0)->x) / sizeof(double) };

static double product(const double row[ORDER], const double x[ORDER]) {
    double sum = 0.0;
    for (int i = 0; i < ORDER; i++)
        sum += row[i] * x[i];
    return sum;
}

/* One sample: x+ = A x + B v_cmd + E a_cmd, v_r = C x+ + D v_cmd. */
static void sample(Memory *w, const Inputs *u, const Parameters *p) {
    double next[ORDER];
    for (int i = 0; i < ORDER; i++)
        next[i] = product(p->A[i], w->x) + p->B[i] * u->v_cmd + p->E[i] * u->a_cmd;
    for (int i = 0; i < ORDER; i++)
        w->x[i] = next[i];
    w->v_held = product(p->C, w->x) + p->D * u->v_cmd;
}

#include "numerics/sampled.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s)};
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    y->v_r = w->v_held;
}
