/* A drive with friction of one of several laws in a sampled velocity or position loop. It shares
   nothing with the product. SI units; for a rotary drive read rad for m and N m for N.
   A substep solves the implicit midpoint rule for one unknown, its mean velocity; ideal stiction
   takes the implicit Euler rule, in which the contact holds exactly. */
#include <math.h>
#include <stddef.h>

#define PI 3.14159265358979323846

enum { NONE, LUGRE, DAHL, GMS, ELASTO_PLASTIC, COULOMB_STRIBECK, ELEMENTS = 5 };

typedef struct {
    double m, b, F_c, F_s, v_s, delta, sigma_0, sigma_1;
    double asymmetry;              /* share by which friction is higher forward, lower backward */
    double uneven, period, origin; /* share, length and phase [m] of friction along the guide */
    double F_0;                    /* constant force against the motor */
    double g_s, g_c, mu_g;         /* an arm's weight: sine and cosine of x; friction over it */
    double pitch, s_1, c_1, s_2, c_2; /* cogging: two harmonics */
    double motor, held;               /* force of motor and integral at the start */
    double K_p, K_i, K_x, velocity_feedforward, tau_f, T_s, u_min, u_max;
    double encoder, phase; /* step, and where in it the drive begins [1] */
    double z_ba;           /* break-away deflection of the elasto-plastic law, over F_c / sigma_0 */
} Drive;

typedef struct {
    double z, force[ELEMENTS];
    int slips[ELEMENTS];
} Contact;

/* What a compensator adds in the period that begins; F_m was measured over the one that ended. */
typedef void (*Begin)(double v_cmd, double x_cmd, double x_enc, double F_m);
typedef double (*Added)(double v_cmd, double x_cmd, double x_enc, double F_m);

static double phi(double y) { return fabs(y) < 1e-6 ? 1.0 - 0.5 * y : -expm1(-y) / y; }
static double phi2(double y) { return fabs(y) < 1e-4 ? 0.5 - y / 6.0 : (1.0 - phi(y)) / y; }

/* magnitude of steady friction */
static double level(int law, const Drive *d, double x, double v) {
    double g = d->F_c;
    if (law != DAHL)
        g += (d->F_s - d->F_c) * exp(-pow(fabs(v) / d->v_s, d->delta));
    g *= 1.0 + d->mu_g * fabs(d->g_s * sin(x) + d->g_c * cos(x)) / d->F_c;
    g *= 1.0 + d->uneven * sin(2.0 * PI * (x - d->origin) / d->period);
    return g * (1.0 + d->asymmetry * ((v > 0.0) - (v < 0.0)));
}

/* mean force over h at a held velocity */
static double bristle(const Drive *d, Contact *s, double v, double h, double g, int elastic) {
    double mean = 0.0;
    for (int k = 0; k < 4; ++k) {
        double hh = h / 4.0, most = g / d->sigma_0, least = d->z_ba * d->F_c / d->sigma_0,
               share = 1.0;
        double away = fabs(s->z);
        if (elastic) {
            if (s->z * v <= 0.0 || away <= least)
                share = 0.0;
            else if (away < most)
                share = 0.5 * sin(PI * (away - 0.5 * (most + least)) / (most - least)) + 0.5;
        }
        double rate = share * d->sigma_0 * fabs(v) / g, dz = v - rate * s->z;
        double bent = s->z + hh * phi2(rate * hh) * dz;
        mean += (d->sigma_0 * bent + d->sigma_1 * phi(rate * hh) * dz) / 4.0;
        s->z += hh * phi(rate * hh) * dz;
    }
    return mean;
}

/* the same of generalised Maxwell slip */
static double maxwell(const Drive *d, Contact *s, double v, double h, double g) {
    static const double alpha[ELEMENTS] = {0.15, 0.25, 0.25, 0.2, 0.15};
    static const double bend[ELEMENTS] = {0.3, 0.7, 1.3, 2.5, 5.0}; /* of F_s / sigma_0 */
    double total = 0.0, before = 0.0, after = 0.0, mean = 0.0, C = 250.0 * d->F_c;
    int sign = (v > 0.0) - (v < 0.0);
    for (int i = 0; i < ELEMENTS; ++i)
        total += alpha[i] / bend[i];
    for (int i = 0; i < ELEMENTS; ++i) {
        double k = d->sigma_0 * alpha[i] / bend[i] / total, f = s->force[i];
        before += f;
        if (sign == 0 || s->slips[i] != sign)
            s->slips[i] = 0;
        double most = alpha[i] * g, left = h, area = 0.0;
        if (sign == 0) {
            area = h * f;
            left = 0.0;
        } else if (s->slips[i] == 0) {
            double until = fmax(0.0, (most - sign * f) / (k * fabs(v))), t = fmin(until, left);
            area += t * (f + 0.5 * k * v * t);
            f += k * v * t;
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

/* force of position against the motor */
static double position_force(const Drive *d, double x) {
    double y = 2.0 * PI * x / d->pitch;
    return d->F_0 + d->g_s * sin(x) + d->g_c * cos(x) + d->s_1 * sin(y) + d->c_1 * cos(y) +
           d->s_2 * sin(2.0 * y) + d->c_2 * cos(2.0 * y);
}

static double friction(int law, const Drive *d, Contact *s, double x, double v, double h) {
    if (law == NONE)
        return 0.0;
    double g = level(law, d, x, v);
    return law == GMS ? maxwell(d, s, v, h, g) : bristle(d, s, v, h, g, law == ELASTO_PLASTIC);
}

/* force that is missing for a mean velocity w over h */
static double missing(int law, const Drive *d, const Contact *s, double x, double v, double w,
                      double h, double u) {
    Contact t = *s;
    return 2.0 * d->m * (w - v) / h + d->b * w + friction(law, d, &t, x, w, h) - u;
}

/* mean velocity over h: the root of ``missing``, bracketed and then found by the Illinois rule */
static double mean_velocity(int law, const Drive *d, const Contact *s, double x, double v, double h,
                            double u) {
    double tolerance = 1e-9 * (d->F_c + fabs(u)), w0 = v, w1 = v;
    double f0 = missing(law, d, s, x, v, v, h, u), f1 = f0, step = -0.5 * f0 * h / d->m;
    if (fabs(f0) <= tolerance)
        return v;
    for (int i = 0; i < 60; ++i) {
        w1 = v + step;
        f1 = missing(law, d, s, x, v, w1, h, u);
        if (f1 * f0 <= 0.0)
            break;
        w0 = w1;
        f0 = f1;
        step *= 2.0;
    }
    for (int i = 0; i < 100 && fabs(f1) > tolerance && f1 != f0; ++i) {
        double w = w1 - f1 * (w1 - w0) / (f1 - f0), f = missing(law, d, s, x, v, w, h, u);
        if (f * f1 < 0.0) {
            w0 = w1;
            f0 = f1;
        } else
            f0 *= 0.5;
        w1 = w;
        f1 = f;
    }
    return w1;
}

/* velocity after h with ideal stiction, 0 where the contact holds */
static double after_stiction(const Drive *d, double x, double v, double h, double u) {
    double push = d->m * v / h + u, side = push > 0.0 ? 1.0 : -1.0;
    double most = level(COULOMB_STRIBECK, d, x, side * 1e-300), a = 0.0, b;
    if (fabs(push) <= most)
        return 0.0;
    b = fabs(push) / (d->m / h + d->b); /* m w / h + b w + g(w) = |push| has one root below */
    for (int i = 0; i < 60 && b - a > 1e-13 * b; ++i) {
        double w = 0.5 * (a + b);
        if ((d->m / h + d->b) * w + level(COULOMB_STRIBECK, d, x, side * w) > fabs(push))
            b = w;
        else
            a = w;
    }
    return side * 0.5 * (a + b);
}

static void substep(int law, const Drive *d, Contact *s, double *x, double *v, double h, double u) {
    if (law == COULOMB_STRIBECK) {
        double next = after_stiction(d, *x, *v, h, u);
        *x += 0.5 * h * (*v + next);
        *v = next;
        return;
    }
    double middle = *x + 0.5 * h * *v, w = mean_velocity(law, d, s, middle, *v, h, u);
    friction(law, d, s, middle, w, h);
    *x += h * w;
    *v = 2.0 * w - *v;
}

/* n samples: position of the encoder, commanded force, measured force, true velocity and position.
   Inputs (n,): commands, feedforward force or NULL, and noise of encoder [steps] and measured
   force [N]. */
__attribute__((visibility("default"))) void
record(int law, const Drive *d, int n, const double *v_cmd, const double *x_cmd, const double *F_ff,
       const double *noise_x, const double *noise_F, Begin begin, Added added, int substeps,
       double *x_enc, double *commanded, double *force, double *v_out, double *x_out) {
    Contact s = {0};
    double x = 0.0, v = 0.0, integral = d->held, estimate = 0.0, last = 0.0, limited = d->motor;
    double weight = d->tau_f > 0.0 ? 1.0 - exp(-d->T_s / d->tau_f) : 1.0;
    for (int k = 0; k < n; ++k) {
        double shown = x;
        if (d->encoder > 0.0)
            shown = floor(x / d->encoder + d->phase + noise_x[k]) * d->encoder;
        double F_m = limited + (k > 0 ? noise_F[k - 1] : 0.0);
        if (k == 0) {
            last = shown;
            if (begin)
                begin(v_cmd[0], x_cmd[0], shown, F_m);
        }
        estimate += weight * ((shown - last) / d->T_s - estimate);
        last = shown;
        double e = d->velocity_feedforward * v_cmd[k] + d->K_x * (x_cmd[k] - shown) - estimate;
        double next = integral + d->T_s * d->K_i * e;
        double u = d->K_p * e + next + (F_ff ? F_ff[k] : 0.0);
        if (added)
            u += added(v_cmd[k], x_cmd[k], shown, F_m);
        limited = fmin(fmax(u, fmax(d->u_min, -d->u_max)), d->u_max);
        if (limited == u || (u - limited) * e < 0.0) /* anti-windup */
            integral = next;
        x_enc[k] = shown;
        commanded[k] = u;
        force[k] = limited + noise_F[k];
        v_out[k] = v;
        x_out[k] = x;
        for (int j = 0; j < substeps; ++j) {
            double h = d->T_s / substeps;
            double held = law == NONE ? 0.0 : position_force(d, x + 0.5 * h * v);
            substep(law, d, &s, &x, &v, h, limited - held);
        }
    }
}
