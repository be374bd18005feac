/* Drives with friction laws that differ from those of the product, in a PI velocity loop with an
   encoder. Each step solves the implicit midpoint rule for one unknown, its mean velocity; ideal
   stiction, which would not damp the last bit of velocity, takes the implicit Euler rule. */
#include <math.h>

#define PI 3.14159265358979323846
#define STILL 1e-8 /* [m/s] below which the contact holds */

enum { LUGRE, DAHL, GMS, ELASTO_PLASTIC, STICTION, ELEMENTS = 5 };

typedef struct {
    double m, b, F_s, F_c, v_s, sigma_0, sigma_1;
    double uneven, period; /* share and length [m] by which friction depends on the position */
    double K_p, K_i, tau_f, T_s, encoder, u_max;
    double integral; /* that the controller holds at first [N] */
} Drive;

typedef struct {
    double z, force[ELEMENTS];
    int slips[ELEMENTS];
} State;

static double phi(double y) { return fabs(y) < 1e-6 ? 1.0 - 0.5 * y : -expm1(-y) / y; }
static double phi2(double y) { return fabs(y) < 1e-4 ? 0.5 - y / 6.0 : (1.0 - phi(y)) / y; }

/* mean force over h at a held velocity */
static double bristle(const Drive *d, State *s, double v, double h, double g, int elastic) {
    double mean = 0.0;
    for (int k = 0; k < 4; ++k) {
        double hh = h / 4.0, most = g / d->sigma_0, least = 0.7 * d->F_c / d->sigma_0, share = 1.0;
        double away = fabs(s->z);
        if (elastic) {
            if (s->z * v <= 0.0 || away <= least)
                share = 0.0;
            else if (away < most)
                share = 0.5 * sin(PI * (away - 0.5 * (most + least)) / (most - least)) + 0.5;
        }
        double rate = share * d->sigma_0 * fabs(v) / g, dz = v - rate * s->z;
        mean +=
            (d->sigma_0 * (s->z + hh * phi2(rate * hh) * dz) + d->sigma_1 * phi(rate * hh) * dz) /
            4.0;
        s->z += hh * phi(rate * hh) * dz;
    }
    return mean;
}

static double maxwell(const Drive *d, State *s, double v, double h, double g) {
    static const double alpha[ELEMENTS] = {0.15, 0.25, 0.25, 0.2, 0.15};
    static const double bend[ELEMENTS] = {0.3, 0.7, 1.3, 2.5, 5.0}; /* of F_s / sigma_0 */
    double k[ELEMENTS], total = 0.0, before = 0.0, after = 0.0, mean = 0.0,
                        C = 1500.0 * d->F_c / 6.0;
    int sign = (v > 0.0) - (v < 0.0);
    for (int i = 0; i < ELEMENTS; ++i)
        total += alpha[i] / bend[i];
    for (int i = 0; i < ELEMENTS; ++i) {
        k[i] = d->sigma_0 * alpha[i] / bend[i] / total;
        before += s->force[i];
        if (sign == 0) {
            s->slips[i] = 0;
            mean += s->force[i];
            after += s->force[i];
            continue;
        }
        double most = alpha[i] * g, left = h, area = 0.0, f = s->force[i];
        if (s->slips[i] != sign)
            s->slips[i] = 0;
        if (s->slips[i] == 0) {
            double until = fmax(0.0, (most - sign * f) / (k[i] * fabs(v))), t = fmin(until, left);
            area += t * (f + 0.5 * k[i] * v * t);
            f += k[i] * v * t;
            left -= t;
            if (until < h)
                s->slips[i] = sign;
        }
        if (left > 0.0) {
            double y = C * left / g, end = sign * most;
            area += left * (end + (f - end) * phi(y));
            f = end + (f - end) * exp(-y);
        }
        s->force[i] = f;
        mean += area / h;
        after += f;
    }
    return mean + d->sigma_1 * (after - before) / (d->sigma_0 * h);
}

static double friction(int law, const Drive *d, State *s, double x, double v, double h) {
    double g = d->F_c + (d->F_s - d->F_c) * exp(-fabs(v) / d->v_s);
    if (law == DAHL)
        g = d->F_c;
    g *= 1.0 + d->uneven * sin(2.0 * PI * x / d->period);
    if (law == STICTION)
        return g * fmax(-1.0, fmin(1.0, v / STILL));
    return law == GMS ? maxwell(d, s, v, h, g) : bristle(d, s, v, h, g, law == ELASTO_PLASTIC);
}

/* n samples of position, commanded force, true velocity; the command is v_cmd */
__attribute__((visibility("default"))) void record(int law, const Drive *d, int n,
                                                   const double *v_cmd, const double *F_ff,
                                                   int substeps, double *x_enc, double *u_out,
                                                   double *applied, double *v_out) {
    State s = {0};
    double x = 0.0, v = 0.0, integral = d->integral, estimate = 0.0, last = 0.0;
    double implicit = law == STICTION ? 1.0 : 2.0;
    double h = d->T_s / substeps, weight = 1.0 - exp(-d->T_s / d->tau_f);
    for (int k = 0; k < n; ++k) {
        double shown = d->encoder > 0.0 ? floor(x / d->encoder) * d->encoder : x;
        if (k == 0)
            last = shown;
        estimate += weight * ((shown - last) / d->T_s - estimate);
        last = shown;
        double error = v_cmd[k] - estimate;
        double next = integral + d->T_s * d->K_i * error;
        double u = d->K_p * error + next + (F_ff ? F_ff[k] : 0.0);
        double limited = fmin(fmax(u, -d->u_max), d->u_max);
        if (limited == u || (u - limited) * error < 0.0)
            integral = next;
        x_enc[k] = shown;
        u_out[k] = u;
        applied[k] = limited;
        v_out[k] = v;
        for (int j = 0; j < substeps; ++j) {
            State t = s;
            double r0 = d->b * v + friction(law, d, &t, x, v, h) - limited;
            double w0 = v, w1 = v, f0 = r0, f1 = r0, step = -r0 * h / (implicit * d->m);
            if (fabs(r0) > 1e-10) {
                for (int i = 0; i < 60; ++i) {
                    w1 = v + step;
                    t = s;
                    f1 = implicit * d->m * (w1 - v) / h + d->b * w1 +
                         friction(law, d, &t, x, w1, h) - limited;
                    if (f1 * f0 <= 0.0)
                        break;
                    w0 = w1;
                    f0 = f1;
                    step *= 2.0;
                }
                double w = w1;
                for (int i = 0; i < 100; ++i) {
                    w = (f1 == f0) ? w1 : w1 - f1 * (w1 - w0) / (f1 - f0);
                    t = s;
                    double f = implicit * d->m * (w - v) / h + d->b * w +
                               friction(law, d, &t, x, w, h) - limited;
                    if (fabs(f) < 1e-10)
                        break;
                    if (f * f1 < 0.0) {
                        w0 = w1;
                        f0 = f1;
                    } else
                        f0 *= 0.5;
                    w1 = w;
                    f1 = f;
                }
                w1 = w;
            }
            friction(law, d, &s, x, w1, h);
            x += h * w1;
            v = law == STICTION ? w1 : 2.0 * w1 - v;
        }
    }
}
