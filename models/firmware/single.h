/* What numerics/elementary.h has, for 32-bit floating point: relative error of exp, log and sin
 * below 2e-7, of sin below 2e-7 where it is 0. */
#include <stdint.h>

/* 2^n for -126 <= n <= 127 */
static float power_of_two(int n) {
    const union {
        uint32_t bits;
        float value;
    } number = {(uint32_t)(n + 127) << 23};
    return number.value;
}

/* e^x; 0 below -87, the largest exponent a normal number has. */
static float elementary_exp(float x) {
    if (!(x >= -87.0f)) /* also when it is not a number */
        return x < -87.0f ? 0.0f : x;
    if (x > 88.0f)
        x = 88.0f;
    const int n = (int)(x * 1.44269504f + (x < 0.0f ? -0.5f : 0.5f));
    const float r = (x - (float)n * 0.693359375f) + (float)n * 2.12194440e-4f;
    const float r2 = r * r;
    const float a = (1.0f + r) + r2 * (1.0f / 2 + r * (1.0f / 6));
    const float b = (1.0f / 24 + r * (1.0f / 120)) + r2 * (1.0f / 720 + r * (1.0f / 5040));
    return (a + r2 * r2 * b) * power_of_two(n);
}

/* ln(x) for x >= 0: 2 artanh((m - 1) / (m + 1)) + e ln 2, with x = m 2^e; at 0 very low. */
static float elementary_log(float x) {
    if (x < 1.17549435e-38f)
        return -1e30f;
    const union {
        float value;
        uint32_t bits;
    } number = {x};
    int e = (int)(number.bits >> 23) - 127;
    float m = x / power_of_two(e);
    if (m > 1.41421356f) {
        m *= 0.5f;
        e++;
    }
    const float s = (m - 1.0f) / (m + 1.0f), s2 = s * s;
    float sum = 0.0f;
    for (int k = 5; k >= 1; k--)
        sum = (sum + 1.0f / (float)(2 * k + 1)) * s2;
    return 2.0f * (s + s * sum) + (float)e * 0.693147181f;
}

/* sin(x) for |x| < 100: Taylor to x^11 on -pi/2 .. pi/2. */
static float elementary_sin(float x) {
    const int n = (int)(x * 0.318309886f + (x < 0.0f ? -0.5f : 0.5f));
    const float r = (x - (float)n * 3.140625f) - (float)n * 9.67653590e-4f;
    const float r2 = r * r;
    float sum = 0.0f;
    for (int k = 5; k >= 1; k--)
        sum = (1.0f + sum) * (-r2 / (float)(2 * k * (2 * k + 1)));
    const float value = r + r * sum;
    return n % 2 != 0 ? -value : value;
}

/* Nearest whole number, |x| < 2^31. */
static float nearest(float x) { return (float)(int)(x + (x < 0.0f ? -0.5f : 0.5f)); }
