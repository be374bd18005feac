/* A second-order section b0 b1 b2 1 a1 a2 of a digital filter in transposed direct form II. */
#include <stdint.h>

__attribute__((visibility("default"))) void filter_in_place(const double s[6], double z[2],
                                                            double x[], int64_t n);

/* Signal x[n] becomes its output; the state z[2] is the one before, then the one after it. */
void filter_in_place(const double s[6], double z[2], double x[], int64_t n) {
    double first = z[0], second = z[1];
    for (int64_t k = 0; k < n; k++) {
        const double in = x[k], out = s[0] * in + first;
        first = s[1] * in - s[4] * out + second;
        second = s[2] * in - s[5] * out;
        x[k] = out;
    }
    z[0] = first;
    z[1] = second;
}
