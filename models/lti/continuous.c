/* dx/dt = A x + B u, y = C x + D u: exact for an input that is held over the step, however long. */
#include <stddef.h>

#include "matrices.h"
#include "model.h"

/* y += a x, with a (rows, columns) row by row */
static void add_product(int rows, int columns, const double a[], const double x[], double y[]) {
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < columns; k++)
            y[i] += a[i * columns + k] * x[k];
}

/* c += a b / n, all (R, R); c is none of the others. */
static void add_matrix_product(const double a[], const double b[], double n, double c[]) {
    for (int i = 0; i < R; i++)
        for (int j = 0; j < R; j++) {
            const double factor = a[i * R + j] / n;
            for (int k = 0; k < R; k++)
                c[i * R + k] += factor * b[j * R + k];
        }
}

static double largest_row_sum(const double a[R * R]) {
    double largest = 0.0;
    for (int i = 0; i < R; i++) {
        double sum = 0.0;
        for (int k = 0; k < R; k++)
            sum += a[i * R + k] < 0.0 ? -a[i * R + k] : a[i * R + k];
        largest = sum > largest ? sum : largest;
    }
    return largest;
}

/* a = e^a - 1: Taylor to a^14 of a / 2^s, whose row sums are at most 0.5, then s squarings. Without
 * the 1 a slow mode keeps its digits beside a fast one: (1 + e)^2 - 1 = 2 e + e^2. */
static void exponential(double a[R * R]) {
    double one[R * R], other[R * R], *e = one, *next = other, *last;
    int s = 0;
    for (double size = largest_row_sum(a); size > 0.5 && s < 1100; size *= 0.5)
        s++;
    for (int k = 0; k < s; k++)
        for (int i = 0; i < R * R; i++)
            a[i] *= 0.5;
    for (int i = 0; i < R * R; i++)
        e[i] = i % (R + 1) == 0 ? 1.0 : 0.0;
    for (int n = 14; n >= 1; n--, last = e, e = next, next = last) { /* Horner: 1 + a e / n */
        for (int i = 0; i < R * R; i++)
            next[i] = n > 1 && i % (R + 1) == 0 ? 1.0 : 0.0;
        add_matrix_product(a, e, n, next);
    }
    for (; s > 0; s--, last = e, e = next, next = last) {
        for (int i = 0; i < R * R; i++)
            next[i] = 2.0 * e[i];
        add_matrix_product(e, e, 1.0, next);
    }
    for (int i = 0; i < R * R; i++)
        a[i] = e[i];
}

/* The Taylor series of x(t + h) itself, in pieces over which A h is at most 0.5. */
static void step_by_series(double h, const double u[], double x[]) {
    const int pieces = 1 + (int)(2.0 * NORM * h);
    for (int k = 0; k < pieces; k++) {
        double term[R] = {0.0};
        add_product(N, N, A, x, term);
        add_product(N, M, B, u, term);
        for (int n = 1; n <= 15; n++) {
            double next[R] = {0.0};
            for (int i = 0; i < N; i++) {
                term[i] *= h / pieces / n;
                x[i] += term[i];
            }
            add_product(N, N, A, term, next);
            for (int i = 0; i < N; i++)
                term[i] = next[i];
        }
    }
}

/* x(t + h) = e^(A h) x + the integral of e^(A s) B u: both are in the exponential of one matrix,
 *
 *     ( A h  w )        w = B u h / scale, so that a large input costs no digits,
 *     (  0   0 )
 *
 * and A and w are balanced: x_i = BALANCE_i times what is computed with. */
static void step_by_exponential(double h, const double u[], double x[]) {
    double w[R] = {0.0}, matrix[R * R] = {0.0}, next[R] = {0.0}, scale = 0.0;
    add_product(N, M, B, u, w);
    for (int i = 0; i < N; i++) {
        w[i] *= h / BALANCE[i];
        const double size = w[i] < 0.0 ? -w[i] : w[i];
        scale = size > scale ? size : scale;
    }
    for (int i = 0; i < N; i++) {
        for (int k = 0; k < N; k++)
            matrix[i * R + k] = A[i * N + k] * BALANCE[k] / BALANCE[i] * h;
        matrix[i * R + N] = scale > 0.0 ? w[i] / scale : 0.0;
    }
    exponential(matrix);
    for (int i = 0; i < N; i++) {
        next[i] = matrix[i * R + N] * scale;
        for (int k = 0; k < N; k++)
            next[i] += matrix[i * R + k] * (x[k] / BALANCE[k]);
    }
    for (int i = 0; i < N; i++)
        x[i] += next[i] * BALANCE[i];
}

/* The step that was foreseen, A_STEP = e^(A STEP) - 1; off by the rounding of two times, dh. */
static void step_foreseen(double dh, const double u[], double x[]) {
    double change[R] = {0.0}, rate[R] = {0.0};
    add_product(N, N, A_STEP, x, change);
    add_product(N, M, B_STEP, u, change);
    for (int i = 0; i < N; i++)
        x[i] += change[i];
    add_product(N, N, A, x, rate);
    add_product(N, M, B, u, rate);
    for (int i = 0; i < N; i++)
        x[i] += dh * rate[i];
}

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {}

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    const double dh = h - STEP;
    if (dh < 1e-8 * STEP && dh > -1e-8 * STEP)
        step_foreseen(dh, INPUTS(u), STATES(x));
    else if (2.0 * NORM * h < (double)N) /* where it takes fewer products */
        step_by_series(h, INPUTS(u), STATES(x));
    else
        step_by_exponential(h, INPUTS(u), STATES(x));
    double sum = 0.0;
    for (int i = 0; i < N; i++)
        sum += STATES(x)[i];
    return sum - sum == 0.0; /* finite */
}

void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y) {
    for (int i = 0; i < P; i++)
        y->y[i] = 0.0;
    add_product(P, N, C, STATES(x), y->y);
    add_product(P, M, D, INPUTS(u), y->y);
}

#ifdef HAS_DERIVATIVES
void model_continuous(double t, const States *x, const Inputs *u, const Parameters *p,
                      Derivatives *dx, Outputs *y) {
    for (int i = 0; i < N; i++)
        dx->x[i] = 0.0;
    add_product(N, N, A, x->x, dx->x);
    add_product(N, M, B, u->u, dx->x);
    model_outputs(t, x, NULL, u, p, y);
}

static void set_rows(int rows, const double by_x[], const double by_u[], Gradient gradient[]) {
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < N; k++)
            gradient[i].x.x[k] = by_x[i * N + k];
        for (int k = 0; k < M; k++)
            gradient[i].u.u[k] = by_u[i * M + k];
    }
}

void model_jacobian(double t, const States *x, const Memory *w, const Inputs *u,
                    const Parameters *p, Jacobian *J) {
    set_rows(N, A, B, J->dx.x);
    set_rows(P, C, D, J->y.y);
}
#endif
