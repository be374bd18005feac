#include "run.h"

/* The exposed inputs of a point in time, those after the end of a lane as at its end. */
INLINE const V *external_at(const LaneRun *run, int64_t n) {
    V *block = run->block;
    const int64_t width = run->n_external;
    for (int k = 0; n % BLOCK == 0 && k < LANES; k++)
        for (int64_t i = 0; run->n_steps[k] && i < BLOCK; i++) {
            const int64_t at = n + i < run->n_steps[k] ? n + i : run->n_steps[k];
            for (int64_t j = 0; j < width; j++)
                ((double *)(block + i * width + j))[k] = run->external[k][at * width + j];
        }
    return block + n % BLOCK * width;
}

INLINE void record(const LaneRun *run, int64_t n, bool last) {
    V *block = run->block + BLOCK * run->n_external;
    for (int64_t i = 0; i < run->n_recorded; i++)
        block[i * BLOCK + n % BLOCK] = run->values[run->recorded[i]];
    if (n % BLOCK != BLOCK - 1 && !last)
        return;
    const int64_t first = n - n % BLOCK;
    for (int k = 0; k < LANES; k++)
        for (int64_t i = 0; run->n_steps[k] && i < run->n_recorded; i++)
            for (int64_t m = first; m <= n; m++)
                run->record[k][i * run->room + m] =
                    ((const double *)(block + i * BLOCK + m % BLOCK))[k];
}

INLINE void set_inputs(const LaneRun *run, const LaneComponent *c, const V *external, M live) {
    V *values = run->values;
    for (int64_t i = 0; i < c->n_wires; i++) {
        const Wire *wire = &c->wires[i];
        const V value = wire->source < 0 ? external[wire->column] : values[wire->source];
        values[wire->target] = live ? value : values[wire->target];
    }
}

/* The sum of the outputs; it is not finite where one of them is not. */
INLINE V sum_of(const LaneRun *run, const LaneComponent *c) {
    V sum = 0.0;
    for (int64_t i = 0; i < c->n_checked; i++)
        sum += run->values[c->checked[i]];
    return sum;
}

INLINE M not_finite(V sum) { return sum - sum != 0.0; }

void LEVEL(run_lanes)(const LaneRun *run);
void LEVEL(run_lanes)(const LaneRun *run) {
    const LaneComponent *end = run->components + run->n_components;
    M live = 0, failed = 0;
    int64_t longest = 0;
    for (int k = 0; k < LANES; k++) {
        live[k] = run->n_steps[k] > 0 ? -1 : 0;
        longest = run->n_steps[k] > longest ? run->n_steps[k] : longest;
    }
    for (const LaneComponent *c = run->components; c != end; c++)
        c->model->start(run->start, run->values + c->first, live);
    for (int sweep = 0; sweep < 2; sweep++) /* the second one finds what depends on itself */
        for (const LaneComponent *c = run->components; c != end; c++) {
            const V before = sum_of(run, c);
            set_inputs(run, c, external_at(run, 0), live);
            c->model->start(run->start, run->values + c->first, live);
            if (sweep)
                failed |= not_finite(sum_of(run, c)) | (sum_of(run, c) != before);
        }
    record(run, 0, longest == 0);
    for (int64_t n = 0; n < longest; n++) {
        const V *external = external_at(run, n);
        const double t = run->start + (double)n * run->step;
        const double h =
            run->constant_step ? run->step : run->start + (double)(n + 1) * run->step - t;
        for (int k = 0; k < LANES; k++)
            live[k] = n < run->n_steps[k] ? -1 : 0;
        live &= ~failed;
        if (!any(live))
            break;
        for (const LaneComponent *c = run->components; c != end; c++) {
            set_inputs(run, c, external, live);
            failed |= live & c->model->step(t, h, run->values + c->first, live);
            failed |= live & not_finite(sum_of(run, c));
        }
        record(run, n + 1, n + 1 == longest);
    }
    for (int k = 0; k < LANES; k++)
        run->failed[k] = failed[k] != 0;
}
