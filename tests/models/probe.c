/* The C of models/ as functions on arrays, and a plain Runge-Kutta method to compare with. */
#include <math.h>
#include <stddef.h>

#include "laws/lugre/lugre.h"
#include "laws/lugre/motion.inc"
#include "numerics/elementary.h"
#include "numerics/noise.h"

/* Of the plant: an even guide. */
double plant_ripple(double x, const Mass *mass) { return 0.0 * x * mass->per_m; }
double plant_roughness(double x, double v, const Mass *mass) {
    return 1.0 + 0.0 * x * v * mass->per_m;
}

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

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
MAP(step_factor, step_factor)

EXPORT void probe_noise(size_t n, double seed, int channel, double y[]);
void probe_noise(size_t n, double seed, int channel, double y[]) {
    for (size_t i = 0; i < n; i++)
        y[i] = noise_draw(seed, channel, (double)i);
}

/* p: F_s, F_c, v_s, sigma_0, sigma_1, delta */
static LuGre contact_of(const double p[6]) {
    return (LuGre){p[0], p[1], 1.0 / p[2], p[3], p[4], p[5], 0.0};
}

/* The equations of the paper once more, with the C library's exp. y: x, v, z */
static void derivative(const double y[3], double u, const Mass *s, const LuGre *p, double dy[3]) {
    const double speed = fabs(y[1]);
    const double g = p->F_c + (p->F_s - p->F_c) * exp(-pow(speed * p->per_v_s, p->delta));
    dy[0] = y[1];
    dy[2] = y[1] - p->sigma_0 * speed / g * y[2];
    dy[1] = (u - s->b * y[1] - p->sigma_0 * y[2] - p->sigma_1 * dy[2]) * s->per_m;
}

static void rk4(double h, double y[3], double u, const Mass *s, const LuGre *p) {
    static const double place[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0, 2.0, 2.0, 1.0};
    double k[3] = {0}, sum[3] = {0};
    for (int stage = 0; stage < 4; stage++) {
        double at[3];
        for (int i = 0; i < 3; i++)
            at[i] = y[i] + place[stage] * h * k[i];
        derivative(at, u, s, p, k);
        for (int i = 0; i < 3; i++)
            sum[i] += weight[stage] * k[i];
    }
    for (int i = 0; i < 3; i++)
        y[i] += h / 6.0 * sum[i];
}

/* mass: m, b. Writes x, v, z after each of n holds of h seconds. */
EXPORT void probe_run(int method, int pieces, double h, size_t n, const double u[],
                      const double mass[2], const double p[6], const double start[3],
                      double motion[][3]);
void probe_run(int method, int pieces, double h, size_t n, const double u[], const double mass[2],
               const double p[6], const double start[3], double motion[][3]) {
    const LuGre contact = contact_of(p);
    const Law law = {
        .F_s = p[0], .F_c = p[1], .v_s = p[2], .sigma_0 = p[3], .sigma_1 = p[4], .delta = p[5]};
    double y[3] = {start[0], start[1], start[2]}, dt = 0.0;
    for (size_t i = 0; i < n; i++) {
        const Mass s = {.per_m = 1.0 / mass[0], .b = mass[1], .u = u[i]};
        Sliding now = {y[0], y[1], y[2]};
        if (method == 0) {
            Motion motion = {now.x, now.v};
            LawState state = {.z = now.z};
            if (!motion_step(h, &motion, &state, &s, &law, &dt))
                motion.v = NAN;
            now = (Sliding){motion.x, motion.v, state.z};
        }
        for (int k = 0; method == 1 && k < pieces; k++) {
            Sliding next;
            try_step(h / pieces, &now, u[i], 1.0, &s, &contact, &next);
            now = next;
        }
        y[0] = now.x, y[1] = now.v, y[2] = now.z;
        for (int k = 0; method == 2 && k < pieces; k++)
            rk4(h / pieces, y, u[i], &s, &contact);
        for (int k = 0; k < 3; k++)
            motion[i][k] = y[k];
    }
}
