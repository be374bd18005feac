/* An FMU for the tests: x' = A x + B u + E, y = C x + D u + F, exact for inputs that are
 * polynomials of degree 2 in time. SIZE states, inputs and outputs. Names a[i,j] as in
 * linear_fmu.py. The exact step is the exponential of the system that has the inputs' derivatives
 * as states too. */
#include <fenv.h>
#include <math.h>
#include <string.h>

enum { N = 2, ORDERS = 3, M = N + N * ORDERS + 1 };
/* References: u x0 y, then the matrices row by row. */
#ifndef MAX_ORDER
#define MAX_ORDER 2 /* of the derivatives that inputs take */
#endif
enum { U, X0 = U + N, Y = X0 + N, A = Y + N, B = A + N * N, C = B + N * N, D = C + N * N };
enum { E = D + N * N, F = E + N, CUBIC = F + N, N_REALS };

typedef struct {
    double real[N_REALS];
    double t, x[N];
    double du[2][N]; /* first and second derivative of the inputs */
} Model;

static void multiply(const double *a, const double *b, double *c) {
    for (int i = 0; i < M; i++) {
        for (int j = 0; j < M; j++) {
            c[i * M + j] = 0.0;
            for (int k = 0; k < M; k++)
                c[i * M + j] += a[i * M + k] * b[k * M + j];
        }
    }
}

static void exponential(double *a) {
    double term[M * M], sum[M * M], product[M * M], norm = 0.0;
    int halvings = 0;
    for (int i = 0; i < M * M; i++)
        norm += fabs(a[i]);
    for (; norm > 0.5; norm /= 2.0)
        halvings++;
    for (int i = 0; i < M * M; i++) {
        a[i] = ldexp(a[i], -halvings);
        sum[i] = term[i] = i % (M + 1) == 0;
    }
    for (int k = 1; k < 16; k++) {
        multiply(term, a, product);
        for (int i = 0; i < M * M; i++) {
            term[i] = product[i] / k;
            sum[i] += term[i];
        }
    }
    for (; halvings > 0; halvings--) {
        multiply(sum, sum, product);
        memcpy(sum, product, sizeof sum);
    }
    memcpy(a, sum, sizeof sum);
}

static int step(Model *m, double h) {
    double z[M], a[M * M] = {0.0}, x[N];
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            a[i * M + j] = h * m->real[A + i * N + j];
            a[i * M + N + j] = h * m->real[B + i * N + j];
        }
        a[i * M + M - 1] = h * m->real[E + i];
        a[(N + i) * M + 2 * N + i] = a[(2 * N + i) * M + 3 * N + i] = h;
        z[i] = m->x[i];
        z[N + i] = m->real[U + i];
        z[2 * N + i] = m->du[0][i];
        z[3 * N + i] = m->du[1][i];
    }
    z[M - 1] = 1.0;
    exponential(a);
    for (int i = 0; i < N; i++) {
        x[i] = 0.0;
        for (int j = 0; j < M; j++)
            x[i] += a[i * M + j] * z[j];
    }
    for (int i = 0; i < N; i++) {
        m->x[i] = x[i];
        m->real[U + i] += h * (m->du[0][i] + h / 2.0 * m->du[1][i]);
        m->du[0][i] += h * m->du[1][i];
    }
    return 0;
}

static double output(const Model *m, int i) {
    double y = m->real[F + i];
    for (int j = 0; j < N; j++) {
        const double u = m->real[U + j];
        y += m->real[C + i * N + j] * m->x[j] +
             m->real[D + i * N + j] * (u + m->real[CUBIC] * u * u * u);
    }
    return y;
}

static int set(Model *m, const unsigned r[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++) {
        m->real[r[i]] = v[i];
        if (r[i] >= U && r[i] < U + N)
            m->du[0][r[i] - U] = m->du[1][r[i] - U] = 0.0;
        if (r[i] >= X0 && r[i] < X0 + N)
            m->x[r[i] - X0] = v[i];
    }
    return 0;
}

static int get(const Model *m, const unsigned r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++)
        v[i] = r[i] >= Y && r[i] < Y + N ? output(m, (int)(r[i] - Y)) : m->real[r[i]];
    return 0;
}

static void start(Model *m) { memset(m, 0, sizeof *m); }

static void derivatives(const Model *m, double dx[]) {
    for (size_t i = 0; i < N; i++) {
        dx[i] = m->real[E + i];
        for (size_t j = 0; j < N; j++)
            dx[i] += m->real[A + i * N + j] * m->x[j] + m->real[B + i * N + j] * m->real[U + j];
    }
#ifdef LEAVES_ROUNDING
    fesetround(FE_UPWARD);
#endif
}

#define SAVES
#define EXCHANGE
#define N_STATES N
#include "fmu.h"

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const unsigned r[], size_t n,
                                       const fmi2Integer order[], const fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) {
        if (order[i] > MAX_ORDER)
            return fmi2Error;
        ((Model *)c)->du[order[i] - 1][r[i] - U] = v[i];
    }
    return fmi2OK;
}
