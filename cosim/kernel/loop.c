/* Newton's method with the Jacobian by finite differences, kept from step to step by Broyden. */
#include "calls.h"
#include "coupling.h"
#include <math.h>

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
    for (int64_t i = 0; i < loop->n; i++) {
        values[loop->columns[i]] = w[i];
    }
    if (!sweep(run, loop)) {
        return false;
    }
    for (int64_t i = 0; i < loop->n; i++) {
        r[i] = values[loop->columns[i]] - w[i];
    }
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
        if (!evaluate(run, loop, values, sweep, x.w, x.dr)) {
            return false;
        }
        x.w[j] = w;
        for (int64_t i = 0; i < n; i++) {
            loop->work[i * n + j] = (x.dr[i] - x.r[i]) / delta;
        }
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

/* dw = - inverse r. Whether it is within the tolerance; the worst is noted. */
static bool propose(Loop *loop) {
    const Work x = view(loop);
    const int64_t n = loop->n;
    double worst = -1.0;
    for (int64_t i = 0; i < n; i++) {
        x.dw[i] = 0.0;
        for (int64_t j = 0; j < n; j++) {
            x.dw[i] -= loop->inverse[i * n + j] * x.r[j];
        }
        const double share = fabs(x.dw[i]) / size(loop, i, x.w[i]);
        if (share > worst) {
            worst = share;
            loop->worst = i;
            loop->change = x.dw[i];
        }
    }
    return worst <= loop->tolerance;
}

static bool unsolved(Run *run, Loop *loop) {
    run->unsolved = loop;
    return fail(run, &run->components[loop->first], "", NOT_SOLVED);
}

bool solve(Run *run, Loop *loop, double *values, Sweep *sweep) {
    const Work x = view(loop);
    const int64_t n = loop->n;
    for (int64_t i = 0; i < n; i++) {
        x.w[i] = values[loop->columns[i]];
    }
    if (!evaluate(run, loop, values, sweep, x.w, x.r)) {
        return false;
    }
    double error = norm(loop, x.r, x.w);
    bool falling = true;
    for (int64_t k = 0; error > 0.0; k++) {
        if (!isfinite(error)) {
            return true; /* whoever looks at the row finds the value that is not, and blames it */
        }
        const bool known = loop->known;
        if (!known && !differentiate(run, loop, values, sweep)) {
            return false;
        }
        if (!loop->known) {
            loop->worst = 0;
            loop->change = x.r[0];
            return unsolved(run, loop);
        }
        if (propose(loop) && known && (error <= loop->tolerance || !falling)) {
            return true; /* w is found, and G(w) as near as rounding lets it come */
        }
        if (k == loop->max_iterations) {
            return unsolved(run, loop);
        }
        for (int64_t i = 0; i < n; i++) {
            x.w[i] += x.dw[i];
            x.dr[i] = x.r[i];
        }
        if (!evaluate(run, loop, values, sweep, x.w, x.r)) {
            return false;
        }
        for (int64_t i = 0; i < n; i++) {
            x.dr[i] = x.r[i] - x.dr[i];
        }
        update_inverse(n, loop->inverse, x.dw, x.dr, x.room);
        const double before = error;
        error = norm(loop, x.r, x.w);
        falling = error < 0.5 * before;
        loop->known = falling || propose(loop);
    }
    return true;
}
