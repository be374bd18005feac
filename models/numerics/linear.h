/* A sampled linear system of up to 8 states: x+ = A x + B v + E a. States that it does not use stay
 * 0. */
#ifndef LINEAR_H
#define LINEAR_H

enum { LOOP_ORDER = 8 };

static inline double linear_output(const double row[LOOP_ORDER], const double x[LOOP_ORDER]) {
    double sum = 0.0;
    for (int i = 0; i < LOOP_ORDER; i++)
        sum += row[i] * x[i];
    return sum;
}

static inline void linear_step(double x[LOOP_ORDER], const double A[LOOP_ORDER][LOOP_ORDER],
                               const double B[LOOP_ORDER], double v, const double E[LOOP_ORDER],
                               double a) {
    double next[LOOP_ORDER];
    for (int i = 0; i < LOOP_ORDER; i++)
        next[i] = linear_output(A[i], x) + B[i] * v + E[i] * a;
    for (int i = 0; i < LOOP_ORDER; i++)
        x[i] = next[i];
}

#endif
