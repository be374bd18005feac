/* The elementary functions and the noise of models/, on arrays; conftest.py defines EXPORT. */
#include <stddef.h>

#include "numerics/elementary.h"
#include "numerics/noise.h"

#define MAP(name, function)                                                                        \
    EXPORT void probe_##name(size_t n, const double x[], double y[]);                              \
    void probe_##name(size_t n, const double x[], double y[]) {                                    \
        for (size_t i = 0; i < n; i++)                                                             \
            y[i] = function(x[i]);                                                                 \
    }

MAP(exp, elementary_exp)
MAP(log, elementary_log)
MAP(sin, elementary_sin)
MAP(phi, elementary_phi)
MAP(phi2, elementary_phi2)

EXPORT void probe_noise(size_t n, double seed, int channel, double y[]);
void probe_noise(size_t n, double seed, int channel, double y[]) {
    for (size_t i = 0; i < n; i++)
        y[i] = noise_draw(seed, channel, (double)i);
}
