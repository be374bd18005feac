/* Newton's method with the Jacobian by finite differences, kept from step to step by Broyden. A
 * step with a new Jacobian is damped until it passes the natural monotonicity test: P. Deuflhard,
 * Newton Methods for Nonlinear Problems, Springer 2004, section 3.3. */
#include "calls.h"
#include "coupling.h"
#include <math.h>

static void swap_rows(int64_t n, double *a, double *b) {
    for (int64_t j = 0; j < n; j++) {
        const double x = a[j];
        a[j] = b[j];
        b[j] = x;
    }
}

/* Gauss and Jordan with the greatest pivot of each column; destroys the matrix. */
static bool invert(int64_t n, double *matrix, double *inverse) {
    for (int64_t i = 0; i < n * n; i++)
        inverse[i] = i % (n + 1) == 0;
    for (int64_t k = 0; k < n; k++) {
        int64_t p = k;
        for (int64_t i = k + 1; i < n; i++)
            p = fabs(matrix[i * n + k]) > fabs(matrix[p * n + k]) ? i : p;
        swap_rows(n, matrix + k * n, matrix + p * n);
        swap_rows(n, inverse + k * n, inverse + p * n);
        const double pivot = matrix[k * n + k];
        if (!(fabs(pivot) > 0.0))
            return false;
        for (int64_t j = 0; j < n; j++) {
            matrix[k * n + j] /= pivot;
            inverse[k * n + j] /= pivot;
        }
        for (int64_t i = 0; i < n; i++) {
            const double share = i == k ? 0.0 : matrix[i * n + k];
            for (int64_t j = 0; share != 0.0 && j < n; j++) {
                matrix[i * n + j] -= share * matrix[k * n + j];
                inverse[i * n + j] -= share * inverse[k * n + j];
            }
        }
    }
    return true;
}

/* Broyden's rule for the inverse B: B += (dw - B dr) (dw' B) / (dw' B dr). */
static void update_inverse(int64_t n, double *inverse, const double *dw, const double *dr,
                           double *work) {
    double *row = work, *error = work + n, scale = 0.0, length = 0.0;
    for (int64_t j = 0; j < n; j++) {
        row[j] = 0.0;
        for (int64_t i = 0; i < n; i++)
            row[j] += dw[i] * inverse[i * n + j];
        scale += row[j] * dr[j];
        length += dw[j] * dw[j];
    }
    if (!(fabs(scale) > 1e-6 * length))
        return; /* it would make the inverse singular */
    for (int64_t i = 0; i < n; i++) {
        error[i] = dw[i];
        for (int64_t j = 0; j < n; j++)
            error[i] -= inverse[i * n + j] * dr[j];
    }
    for (int64_t i = 0; i < n * n; i++)
        inverse[i] += error[i / n] * row[i % n] / scale;
}

/* Views into Loop.work. The first n * n are the Jacobian. */
typedef struct {
    double *w, *r, *dw, *dr; /* unknowns, G(w) - w, their changes */
    double *room;            /* 2 n */
} Work;

static Work view(const Loop *loop) {
    double *p = loop->work + loop->n * loop->n;
    return (Work){p, p + loop->n, p + 2 * loop->n, p + 3 * loop->n, p + 4 * loop->n};
}

static double size(const Loop *loop, int64_t i, double w) {
    return fmax(fabs(w), loop->nominal[i]);
}

/* r = G(w) - w. The FMUs then are where w led them. */
static bool evaluate(Run *run, Loop *loop, double *values, Sweep *sweep, const double *w,
                     double *r) {
    for (int64_t i = 0; i < loop->n; i++)
        values[loop->columns[i]] = w[i];
    TRY(sweep(run, loop));
    for (int64_t i = 0; i < loop->n; i++)
        r[i] = values[loop->columns[i]] - w[i];
    return true;
}

/* Spoils dw and dr. A singular Jacobian makes no step: the change stays, and is reported. */
static bool differentiate(Run *run, Loop *loop, double *values, Sweep *sweep) {
    const Work x = view(loop);
    const int64_t n = loop->n;
    for (int64_t j = 0; j < n; j++) {
        const double w = x.w[j];
        x.w[j] += 1e-8 * size(loop, j, w);
        const double delta = x.w[j] - w;
        TRY(evaluate(run, loop, values, sweep, x.w, x.dr));
        x.w[j] = w;
        for (int64_t i = 0; i < n; i++)
            loop->work[i * n + j] = (x.dr[i] - x.r[i]) / delta;
    }
    loop->known = invert(n, loop->work, loop->inverse);
    return true;
}

static double norm(const Loop *loop, const double *r, const double *w) {
    double result = 0.0;
    for (int64_t i = 0; i < loop->n; i++) {
        const double share = fabs(r[i]) / size(loop, i, w[i]);
        result = share <= result ? result : share; /* what is not finite comes through */
    }
    return result;
}

/* dw = - inverse r. Whether it is within the tolerance; the worst is checked. */
static bool newton_step(Loop *loop) {
    const Work x = view(loop);
    const int64_t n = loop->n;
    double worst = -1.0;
    for (int64_t i = 0; i < n; i++) {
        x.dw[i] = 0.0;
        for (int64_t j = 0; j < n; j++)
            x.dw[i] -= loop->inverse[i * n + j] * x.r[j];
        const double share = fabs(x.dw[i]) / size(loop, i, x.w[i]);
        if (share > worst) {
            worst = share;
            loop->worst = i;
            loop->change = x.dw[i];
        }
    }
    return worst <= loop->tolerance;
}

/* Whether the correction with the old Jacobian at the new point is shorter than the step to it was,
 * relative to the values before the step. */
static bool contracts(const Loop *loop, double share) {
    const Work x = view(loop);
    const int64_t n = loop->n;
    double level = 0.0, before = 0.0;
    for (int64_t i = 0; i < n; i++) {
        double correction = 0.0;
        for (int64_t j = 0; j < n; j++)
            correction += loop->inverse[i * n + j] * x.r[j];
        const double scale = size(loop, i, x.w[i] - share * x.dw[i]);
        const double length = fabs(correction) / scale;
        level = length <= level ? level : length;
        before = fmax(before, fabs(x.dw[i]) / scale);
    }
    return level <= fmax((1.0 - share / 4.0) * before, loop->tolerance);
}

/* From w by dw, or by a share of it, to r there; r at the begin goes to dr. A Jacobian that was
 * kept is not trusted so far: only what is not finite makes it take less. *whole: all of dw. */
static bool take_step(Run *run, Loop *loop, double *values, Sweep *sweep, bool kept, bool *whole) {
    static const double LEAST = 1.0 / 1024.0;
    const Work x = view(loop);
    const int64_t n = loop->n;
    double share = 1.0;
    for (int64_t i = 0; i < n; i++) {
        x.w[i] += x.dw[i];
        x.dr[i] = x.r[i];
    }
    TRY(evaluate(run, loop, values, sweep, x.w, x.r));
    while (share > LEAST && !contracts(loop, share) && !(kept && isfinite(norm(loop, x.r, x.w)))) {
        share /= 2.0;
        for (int64_t i = 0; i < n; i++)
            x.w[i] -= share * x.dw[i];
        TRY(evaluate(run, loop, values, sweep, x.w, x.r));
    }
    for (int64_t i = 0; i < n; i++) {
        x.dw[i] *= share;
        x.dr[i] = x.r[i] - x.dr[i];
    }
    *whole = share == 1.0;
    return true;
}

static bool unsolved(Run *run, Loop *loop) {
    run->unsolved = loop;
    return fail(run, &run->components[loop->first], "", NOT_SOLVED);
}

bool solve(Run *run, Loop *loop, double *values, Sweep *sweep) {
    const Work x = view(loop);
    const int64_t n = loop->n;
    for (int64_t i = 0; i < n; i++)
        x.w[i] = values[loop->columns[i]];
    TRY(evaluate(run, loop, values, sweep, x.w, x.r));
    double error = norm(loop, x.r, x.w);
    bool falling = true;
    for (int64_t k = 0; error > 0.0; k++) {
        if (!isfinite(error))
            return true; /* whoever looks at the row finds the value that is not, and blames it */
        const bool known = loop->known;
        if (!known && !differentiate(run, loop, values, sweep))
            return false;
        if (!loop->known) {
            loop->worst = 0;
            loop->change = x.r[0];
            return unsolved(run, loop);
        }
        if (newton_step(loop) && (known ? error <= loop->tolerance : !falling)) {
            /* w is found, and G(w) as near as rounding lets it come. */
            return known || evaluate(run, loop, values, sweep, x.w, x.r);
        }
        if (k == loop->max_iterations)
            return unsolved(run, loop);
        bool whole;
        TRY(take_step(run, loop, values, sweep, known, &whole));
        update_inverse(n, loop->inverse, x.dw, x.dr, x.room);
        const double before = error;
        error = norm(loop, x.r, x.w);
        falling = error < 0.5 * before;
        loop->known = (falling && whole) || error <= loop->tolerance;
    }
    return true;
}
