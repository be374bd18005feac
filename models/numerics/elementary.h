/* exp, log and sin in basic arithmetic only: the same bits on every platform.
 *
 * The C library's own differ between systems in the last bit, and a friction model turns a last
 * bit into another sub-step. Relative error below 3e-16; tests/models/test_elementary.py holds it.
 */
#ifndef ELEMENTARY_H
#define ELEMENTARY_H

#include <stdbool.h>
#include <stdint.h>

/* 2^n for -1022 <= n <= 1023 */
static inline double power_of_two(int n) {
    const union {
        uint64_t bits;
        double value;
    } number = {(uint64_t)(n + 1023) << 52};
    return number.value;
}

/* Nearest whole number, |x| < 2^51. Adding 1.5 * 2^52 leaves no room for a fraction. */
static inline double nearest(double x) {
    const double shift = 6755399441055744.0;
    return (x + shift) - shift;
}

/* |x| */
static inline double absolute(double x) { return x < 0.0 ? -x : x; }

/* -1, 0 or 1 */
static inline double sign_of(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0; }

/* x, limited to -1 .. 1 */
static inline double clipped(double x) { return x > 1.0 ? 1.0 : x < -1.0 ? -1.0 : x; }

/* x, limited to -most .. most */
static inline double limited(double x, double most) {
    return x > most ? most : x < -most ? -most : x;
}

/* e^r for |r| <= ln(2) / 2: Taylor to r^13, summed in pairs. */
static inline double exp_reduced(double r) {
    const double r2 = r * r, r4 = r2 * r2, r8 = r4 * r4;
    const double a = (1.0 + r) + r2 * (1.0 / 2 + r * (1.0 / 6));
    const double b = (1.0 / 24 + r * (1.0 / 120)) + r2 * (1.0 / 720 + r * (1.0 / 5040));
    const double c =
        (1.0 / 40320 + r * (1.0 / 362880)) + r2 * (1.0 / 3628800 + r * (1.0 / 39916800));
    const double d = 1.0 / 479001600 + r * (1.0 / 6227020800);
    return a + r4 * (b + r4 * c + r8 * d);
}

/* e^x; 0 below -708, the largest exponent a normal number has. */
static inline double elementary_exp(double x) {
    if (!(x >= -708.0)) /* also when it is not a number */
        return x < -708.0 ? 0.0 : x;
    if (x > 709.0)
        x = 709.0;
    const double n = nearest(x * 1.4426950408889634);
    const double r = (x - n * 0.6931471803691238) - n * 1.9082149292705877e-10;
    return exp_reduced(r) * power_of_two((int)n);
}

/* 1/2! - y/3! + y^2/4! - ... to y^13 for 0 <= y <= 0.5, summed in pairs. */
static inline double phi2_series(double y) {
    const double y2 = y * y, y4 = y2 * y2, y8 = y4 * y4;
    const double a = (1.0 / 2 - y * (1.0 / 6)) + y2 * (1.0 / 24 - y * (1.0 / 120));
    const double b = (1.0 / 720 - y * (1.0 / 5040)) + y2 * (1.0 / 40320 - y * (1.0 / 362880));
    const double c =
        (1.0 / 3628800 - y * (1.0 / 39916800)) + y2 * (1.0 / 479001600 - y * (1.0 / 6227020800.0));
    const double d = 1.0 / 87178291200.0 - y * (1.0 / 1307674368000.0);
    return a + y4 * b + y8 * (c + y4 * d);
}

/* phi(y) = (1 - e^-y) / y for y >= 0, without cancellation near 0. */
static inline double elementary_phi(double y) {
    return y > 0.5 ? (1.0 - elementary_exp(-y)) / y : 1.0 - y * phi2_series(y);
}

/* (1 - phi(y)) / y for y >= 0, likewise. */
static inline double elementary_phi2(double y) {
    return y > 0.5 ? (1.0 - elementary_phi(y)) / y : phi2_series(y);
}

/* ln(x) for normal x > 0: 2 artanh((m - 1) / (m + 1)) + e ln 2, with x = m 2^e. */
static inline double elementary_log(double x) {
    const union {
        double value;
        uint64_t bits;
    } number = {x};
    int e = (int)(number.bits >> 52) - 1023;
    double m = x / power_of_two(e);
    if (m > 1.4142135623730951) {
        m *= 0.5;
        e++;
    }
    const double s = (m - 1.0) / (m + 1.0), s2 = s * s;
    double sum = 0.0;
    for (int k = 12; k >= 1; k--)
        sum = (sum + 1.0 / (2 * k + 1)) * s2;
    return 2.0 * (s + s * sum) + e * 0.6931471805599453;
}

/* sin(r) / r - 1 for |r| <= pi / 2: Taylor to r^20, summed in pairs; r2 is r^2. */
static inline double sin_reduced(double r2) {
    const double r4 = r2 * r2, r8 = r4 * r4;
    const double a = -1.0 / 6 + r2 * (1.0 / 120) + r4 * (-1.0 / 5040 + r2 * (1.0 / 362880));
    const double b = -1.0 / 39916800 + r2 * (1.0 / 6227020800.0) +
                     r4 * (-1.0 / 1307674368000.0 + r2 * (1.0 / 355687428096000.0));
    const double c = -1.0 / 121645100408832000.0 + r2 * (1.0 / 51090942171709440000.0);
    return r2 * (a + r8 * (b + r8 * c));
}

/* sin(x) for |x| < 1e5 */
static inline double elementary_sin(double x) {
    const double n = nearest(x * 0.3183098861837907);
    const double r =
        ((x - n * 3.1415926218032837) - n * 3.1786509424591713e-08) - n * 1.2246467991473532e-16;
    const double value = r + r * sin_reduced(r * r);
    const bool odd = n - 2.0 * nearest(0.5 * n) != 0.0;
    return odd ? -value : value;
}

#endif
