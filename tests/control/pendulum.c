/* A driven pendulum for Model Exchange, FMI 2.0 and FMI 3.0, with its derivatives in closed form:
 *
 *   d theta/dt = omega,  d omega/dt = -k sin(theta) - c omega |omega| + torque
 *   x = sin(theta),  power = torque omega
 */
#include <math.h>
#include <stddef.h>

enum { THETA, OMEGA, TORQUE, K, DRAG, X, POWER, D_THETA, D_OMEGA, COUNT };

static void evaluate(double v[COUNT]) {
    v[X] = sin(v[THETA]);
    v[POWER] = v[TORQUE] * v[OMEGA];
    v[D_THETA] = v[OMEGA];
    v[D_OMEGA] = -v[K] * sin(v[THETA]) - v[DRAG] * v[OMEGA] * fabs(v[OMEGA]) + v[TORQUE];
}

static double derivative(const double v[COUNT], unsigned unknown, unsigned known) {
    if (unknown == X)
        return known == THETA ? cos(v[THETA]) : 0.0;
    if (unknown == POWER)
        return known == TORQUE ? v[OMEGA] : known == OMEGA ? v[TORQUE] : 0.0;
    if (unknown == D_THETA)
        return known == OMEGA ? 1.0 : 0.0;
    if (known == TORQUE)
        return 1.0;
    return known == OMEGA ? -2.0 * v[DRAG] * fabs(v[OMEGA]) : -v[K] * cos(v[THETA]);
}

typedef struct {
    double x[COUNT], t; /* first the states */
} Model;

static void start(Model *m) { m->x[K] = 9.81; }

static int get(Model *m, const unsigned r[], size_t n, double values[]) {
    evaluate(m->x);
    for (size_t i = 0; i < n; i++)
        values[i] = m->x[r[i]];
    return 0;
}

static int set(Model *m, const unsigned r[], size_t n, const double values[]) {
    for (size_t i = 0; i < n; i++)
        m->x[r[i]] = values[i];
    return 0;
}

static void derivatives(Model *m, double dx[]) {
    evaluate(m->x);
    dx[0] = m->x[D_THETA], dx[1] = m->x[D_OMEGA];
}

static int vary(const double v[COUNT], const unsigned unknown[], size_t n, const unsigned known[],
                size_t m, const double seed[], double sensitivity[]) {
    for (size_t i = 0; i < n; i++) {
        sensitivity[i] = 0.0;
        for (size_t k = 0; k < m; k++)
            sensitivity[i] += derivative(v, unknown[i], known[k]) * seed[k];
    }
    return 0;
}

#define STEP 3
#define EXCHANGE
#define N_STATES 2
#include "fmu.h"

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const unsigned u[], size_t n,
                                        const unsigned k[], size_t m, const fmi2Real seed[],
                                        fmi2Real s[]) {
    return (fmi2Status)vary(((Model *)c)->x, u, n, k, m, seed, s);
}
fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const unsigned u[], size_t n,
                                        const unsigned k[], size_t m, const fmi3Float64 seed[],
                                        size_t o, fmi3Float64 s[], size_t p) {
    return (fmi3Status)vary(((Model *)c)->x, u, n, k, m, seed, s);
}
