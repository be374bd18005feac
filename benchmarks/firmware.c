/* The exported compensator over a command, and as many exponentials of the C library. */
#include <math.h>
#include <stddef.h>

#include "compensator.h"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

static double velocity(size_t i) { return 4e-5 * (double)((i * 7919) % 2001) - 0.04; }

EXPORT double steps(size_t n);
double steps(size_t n) {
    Compensator c;
    double sum = 0.0;
    compensator_init(&c, (compensator_real)velocity(0));
    for (size_t i = 0; i < n; i++) {
        compensator_step(&c, (compensator_real)5e-4, (compensator_real)velocity(i));
        sum += (double)c.outputs.F_mean;
    }
    return sum;
}

EXPORT double exponentials(size_t n);
double exponentials(size_t n) {
    double sum = 0.0;
    for (size_t i = 0; i < n; i++)
        sum += exp(25.0 * velocity(i));
    return sum;
}
