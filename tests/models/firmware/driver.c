/* Runs the exported compensator over a command, as firmware would. */
#include <stddef.h>

#include "compensator.h"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

typedef compensator_real real;

/* settings: hold, lead [s], b [N s/m], delta. Writes F_mean and F_f [N] after each step; returns
 * how many steps were finite. */
EXPORT size_t drive(size_t n, double h, const double v[], const double settings[4],
                    double force[][2]);
size_t drive(size_t n, double h, const double v[], const double settings[4], double force[][2]) {
    Compensator c;
    size_t finite = 0;
    compensator_init(&c, (real)v[0]);
    c.parameters.hold = (real)settings[0];
    c.parameters.lead = (real)settings[1];
    c.parameters.b = (real)settings[2];
    c.parameters.delta = (real)settings[3];
    for (size_t i = 0; i < n; i++) {
        finite += compensator_step(&c, (real)h, (real)v[i]);
        force[i][0] = (double)c.outputs.F_mean;
        force[i][1] = (double)c.outputs.F_f;
    }
    return finite;
}
