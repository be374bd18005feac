/* From one point in time to the next: in one attempt, or in steps as long as the prediction of the
 * coupling signals holds.
 *
 * The inputs of a step were extrapolated, or could have been. How far the extrapolation misses what
 * came out in the end measures the error that the coupling makes, whatever the method. Where it
 * misses by more than the tolerance, the FMUs go back and try a shorter step. */
#include "calls.h"
#include "coupling.h"
#include <math.h>
#include <string.h>

static const double SAFETY = 0.9, SHRINK = 0.1, GROW = 2.0;

/* The greatest miss in tolerances. */
static double prediction_error(const Run *run) {
    const Coupling *k = run->coupling;
    double worst = 0.0;
    for (const Component *c = run->components; c != run->components + k->n_members; c++) {
        for (int64_t i = c->column; i < c->column + (int64_t)c->n_linked; i++) {
            const double wanted = k->next[i];
            const Polynomial before = hold(run, i, false, k->t, k->h, k->predicted);
            const double error = wanted - value_at(before, k->h);
            const double scale = fmax(fabs(wanted), k->nominal[i]);
            worst = fmax(worst, fabs(error) / scale / k->tolerance);
        }
    }
    return worst;
}

static double rescaled(const Coupling *k, double error) {
    const int64_t known = k->n_past - 1;
    const double order = 1.0 + (double)(known < k->predicted ? known : k->predicted);
    const double factor = error > 0.0 ? SAFETY * pow(error, -1.0 / order) : GROW;
    return fmax(k->min_step, k->h * fmin(fmax(factor, SHRINK), GROW));
}

/* Inputs from outside are joined by straight lines, or hold where the degree is 0. */
static void interpolate(const Run *run, const double *before, const double *after, double share) {
    const Coupling *k = run->coupling;
    for (int64_t i = 0; i < run->n_external; i++) {
        const double rise = after[i] - before[i];
        k->next[i] = share == 1.0 ? after[i] : before[i] + (k->degree > 0 ? share * rise : 0.0);
    }
}

static bool step_adaptively(Run *run, const double *inputs, double t, double h) {
    Coupling *k = run->coupling;
    const double *before = row_of(run, run->done);
    const double end = t + h;
    bool tried_again = false;
    for (double now = t;;) {
        const bool last = k->inner >= 0.999 * (end - now);
        const double reached = last ? end : now + fmin(k->inner, (end - now) / 2.0);
        interpolate(run, before, inputs, last ? 1.0 : (reached - t) / h);
        TRY(attempt(run, now, reached - now));
        const double error = prediction_error(run);
        if (error > 1.0 && k->h > 1.01 * k->min_step) {
            TRY(restore(run, 0, k->n_members));
            k->rejected++;
            tried_again = true;
            k->inner = rescaled(k, error);
            continue;
        }
        const double proposal = tried_again ? k->h : rescaled(k, error);
        tried_again = false;
        k->inner = last ? fmax(k->inner, proposal) : proposal;
        if (last)
            return true;
        now = reached;
        keep(run, k->next, now);
    }
}

static bool step_coupled(Run *run, double *row, double t, double h) {
    Coupling *k = run->coupling;
    const double *inputs = k->ends ? k->ends + (run->done + 1) * run->n_external : row;
    memcpy(k->next, inputs, (size_t)run->n_external * sizeof *row);
    const bool stepped =
        k->tolerance > 0.0 ? step_adaptively(run, inputs, t, h) : attempt(run, t, h);
    for (int64_t i = 0; i < k->n_members; i++) {
        const Component *c = &run->components[i];
        const bool reached = (run->done + 1) % k->members[i].every == 0;
        const size_t size = c->n_outputs * sizeof *row;
        memcpy(row + c->column, (reached ? k->next : k->past) + c->column, size);
    }
    if (stepped)
        keep(run, row, t + h);
    return stepped;
}

bool couple_until(Run *run, int64_t end) {
    while (run->done < end) {
        const int64_t next = run->done + 1;
        const double t = run->start + (double)run->done * run->step;
        const double t_next = run->start + (double)next * run->step;
        run->t = t;
        run->h = run->constant_step ? run->step : t_next - t;
        TRY(step_coupled(run, row_of(run, next), t, run->h));
        run->done = next;
    }
    return true;
}
