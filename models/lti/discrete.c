/* x+ = A x + B u, y = C x + D u, every T_s seconds whatever the step; y is held in between. */
#include "matrices.h"
#include "model.h"
#include "numerics/sampling.h"

/* y += a x, with a (rows, columns) row by row */
static void add_product(int rows, int columns, const double a[], const double x[], double y[]) {
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < columns; k++)
            y[i] += a[i * columns + k] * x[k];
}

static void output(const double x[], const double u[], double y[P]) {
    for (int i = 0; i < P; i++)
        y[i] = 0.0;
    add_product(P, N, C, x, y);
    add_product(P, M, D, u, y);
}

/* x is the state at sample k, the next to be taken. */
void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    w->k = first_sample(t, STEP);
    output(STATES(x), INPUTS(u), w->y);
}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    double sum = 0.0;
    if (!samples_countable(w->k, STEP, t + h))
        return false;
    for (; sample_due(w->k, STEP, t + h); w->k += 1.0) {
        double next[R] = {0.0};
        output(STATES(x), INPUTS(u), w->y);
        add_product(N, N, A, STATES(x), next);
        add_product(N, M, B, INPUTS(u), next);
        for (int i = 0; i < N; i++)
            sum += STATES(x)[i] = next[i];
    }
    return sum - sum == 0.0; /* finite */
}

/* Has output i a direct gain? Then the sample that is due has to wait for its input. */
static bool is_direct(int i) {
    bool direct = false;
    for (int k = 0; k < M; k++)
        direct = direct || D[i * M + k] != 0.0;
    return direct;
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    double next[P];
    output(STATES(x), INPUTS(u), next);
    const bool due = sample_due(w->k, STEP, t + 2e-6 * STEP); /* at t itself */
    for (int i = 0; i < P; i++)
        y->y[i] = due && !(HELD && is_direct(i)) ? next[i] : w->y[i];
}
