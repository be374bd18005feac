#include "calls.h"
#include "coupling.h"
#include "steps.h"
#include <math.h>
#include <string.h>
#include <time.h>

/* For calls that the kernel does not make. */
EXPORT void begin_plain_arithmetic(Arithmetic *before);
void begin_plain_arithmetic(Arithmetic *before) { *before = begin_plain(); }
EXPORT void end_plain_arithmetic(const Arithmetic *before);
void end_plain_arithmetic(const Arithmetic *before) { end_plain(before); }

#ifdef MARKED
static Mark nowhere;
Mark *mark = &nowhere;
EXPORT void mark_in(Mark *place);
void mark_in(Mark *place) { mark = place; }
#endif

#define FOR_EACH_COMPONENT(c)                                                                      \
    for (Component *c = run->components, *end = c + run->n_components; c != end; c++)

/* Before the first step rows 0 and 1 are the same point in time: a fresh input reads the latter. */
static bool get_initial(Run *run, const Component *c) {
    double *values = run->rows + c->column;
    TRY(get_outputs(run, c, c->n_linked, run->rows));
    memcpy(values + run->width, values, c->n_linked * sizeof *values);
    return true;
}

/* Outputs that depend on inputs that depend on outputs, in initialisation mode: set and get until
 * all agree. */
static bool sweep(Run *run, Loop *loop) {
    double *next = run->rows + run->width;
    for (int64_t j = 0; j < loop->n; j++)
        next[loop->columns[j]] = run->rows[loop->columns[j]];
    for (int64_t i = loop->first; i < loop->end; i++) {
        const Component *c = &run->components[i];
        TRY(set_inputs(run, c, run->rows) && get_initial(run, c));
    }
    return true;
}

static bool initialise(Run *run) {
    MARK_TIME(NAN);
    if (run->external) {
        const size_t size = (size_t)run->n_external * sizeof *run->rows;
        memcpy(run->rows, run->external, size);
        memcpy(run->rows + run->width, run->external, size);
    }
    FOR_EACH_COMPONENT(c) {
        clear_log(c->log);
        TRY(!c->used || reset(run, c));
        c->used = 1;
        TRY(enter_initialization(run, c));
    }
    FOR_EACH_COMPONENT(c) { TRY(get_initial(run, c)); }
    FOR_EACH_COMPONENT(c) { TRY(set_inputs(run, c, run->rows) && get_initial(run, c)); }
    if (run->initial) {
        run->initial->known = false;
        TRY(solve(run, run->initial, run->rows, sweep));
    }
    FOR_EACH_COMPONENT(c) { TRY(exit_initialization(run, c)); }
    FOR_EACH_COMPONENT(c) { TRY(get_outputs(run, c, c->n_outputs, run->rows)); }
    return true;
}

/* A sum is not finite if one of its terms is not. Where it only overflows, all are looked at. */
static bool looks_finite(const double *values, int64_t n) {
    typedef double Pair __attribute__((vector_size(16), aligned(8), may_alias));
    Pair sums[4] = {{0.0}};
    int64_t i = 0;
    for (; i + 7 < n; i += 8)
        for (int64_t j = 0; j < 4; j++)
            sums[j] += *(const Pair *)(values + i + 2 * j);
    double sum = 0.0;
    for (; i < n; i++)
        sum += values[i];
    const Pair all = sums[0] + sums[1] + sums[2] + sums[3];
    return isfinite(sum + all[0] + all[1]);
}

/* Look at the outputs in row n of the components before end; blame the first that is not finite. */
static bool all_finite(Run *run, int64_t n, const Component *end) {
    const double *row = row_of(run, n);
    for (const Component *c = run->components; c != end; c++) {
        for (size_t i = 0; i < c->n_outputs; i++) {
            if (!isfinite(row[c->column + (int64_t)i])) {
                run->done = n - 1;
                run->output = (int64_t)i;
                return fail(run, c, c->version == 2 ? "fmi2GetReal" : "fmi3GetFloat64", NOT_FINITE);
            }
        }
    }
    return true;
}

/* A step failed. Where a value before it was not finite, that one is to blame. Always false. */
static bool trace_back(Run *run, int64_t first) {
    const int64_t last = run->done;
    const Component *failed = run->components + run->failed;
    if (run->allows_nan)
        return false;
    for (int64_t n = first; n <= last; n++)
        TRY(all_finite(run, n, run->components + run->n_components));
    if (!run->jacobi)
        all_finite(run, last + 1, failed);
    return false;
}

/* Note which components have moved in the rows first to last; one that is checked is not looked at.
 */
static void note_moved(Run *run, int64_t first, int64_t last) {
    for (int64_t i = 0; run->moved && i < run->n_components; i++) {
        const Component *c = &run->components[i];
        const size_t size = c->n_outputs * sizeof(double);
        for (int64_t n = first; n <= last && !run->moved[i] && size; n++)
            run->moved[i] = memcmp(row_of(run, n) + c->column, run->began + c->column, size) != 0;
    }
}

/* Widen the range (3, n_selected) of the record by n points; a value that is no number stays. */
static void record_range(Run *run, const double *row, int64_t stride, int64_t n) {
    double *least = run->record, *greatest = least + run->n_selected;
    double *end = greatest + run->n_selected;
    for (int64_t i = 0; i < run->n_selected; i++) {
        const double *value = row + run->selected[i];
        double low = run->ranged ? least[i] : *value, high = run->ranged ? greatest[i] : *value;
        for (int64_t k = 0; k < n; k++, value += stride) {
            low = *value < low ? *value : low;
            high = *value > high ? *value : high;
            if (UNLIKELY(isnan(*value)))
                low = high = *value;
            end[i] = *value;
        }
        least[i] = low;
        greatest[i] = high;
    }
    run->ranged += n;
}

/* Of the rows from first to last, those of every n-th step. */
static void record_rows(Run *run, int64_t first, int64_t last) {
    const int64_t begin = (first + run->every - 1) / run->every, end = last / run->every + 1;
    const int64_t stride = run->every * run->width;
    if (!run->record || begin >= end)
        return;
    if (run->ranged >= 0) {
        record_range(run, row_of(run, begin * run->every), stride, end - begin);
        return;
    }
    for (int64_t i = 0; i < run->n_selected; i++) {
        const double *value = row_of(run, begin * run->every) + run->selected[i];
        double *record = run->record + begin * run->n_selected + i;
        for (int64_t k = begin; k < end; k++) {
            *record = *value;
            record += run->n_selected;
            value += stride;
        }
    }
}

/* Check the rows up to the last step done, and record what is kept of them. */
static bool close_rows(Run *run) {
    const int64_t first = run->closed + 1, last = run->done;
    if (!run->allows_nan &&
        UNLIKELY(!looks_finite(row_of(run, first), (last - first + 1) * run->width))) {
        for (int64_t n = first; n <= last; n++)
            TRY(all_finite(run, n, run->components + run->n_components));
    }
    record_rows(run, first, last);
    note_moved(run, first, last);
    run->closed = last;
    return true;
}

bool end_early(Run *run, bool further) {
    run->done += further;
    return close_rows(run);
}

static bool step_block(Run *run, int64_t end) {
    const int64_t first = run->done;
    if (run->used_again) {
        memmove(run->rows, row_of(run, first), (size_t)run->width * sizeof(double));
        run->block_start = first;
    }
    for (int64_t n = first; run->external && n <= end; n++) {
        memcpy(row_of(run, n), run->external + n * run->n_external,
               (size_t)run->n_external * sizeof(double));
    }
    const bool stepped = run->coupling ? couple_until(run, end) : step_until(run, end);
    restore_plain();
    TRY(stepped || trace_back(run, first + 1));
    return close_rows(run);
}

/* Make the changes of parameters that are due. */
static bool tune(Run *run) {
    for (; run->next_change < run->n_changes; run->next_change++) {
        const Change *change = &run->changes[run->next_change];
        if (change->step > run->done)
            break;
        const Component *c = &run->components[change->component];
        TRY(change->step < run->done || set_values(run, c, &change->setting));
    }
    return true;
}

static enum Outcome go_on(Run *run) {
    if (run->done < 0) {
        run->block_start = 0;
        run->closed = -1;
        run->t = run->start;
        run->answers = (Answers){false, false, false, run->start};
        if (!initialise(run))
            return FAILED;
        run->done = 0;
        if (run->began)
            memcpy(run->began, run->rows, (size_t)run->width * sizeof *run->began);
        if (!close_rows(run))
            return FAILED;
        if (run->coupling && !begin_coupled(run))
            return FAILED;
    }
    run->event = 0;
    seek_event(run, run->done);
    const time_t second = time(NULL);
    while (run->done < run->halt) {
        const int64_t left = run->halt - run->done;
        int64_t end = run->done + (left < run->block ? left : run->block);
        if (!tune(run))
            return FAILED;
        if (run->next_change < run->n_changes && run->changes[run->next_change].step < end)
            end = run->changes[run->next_change].step;
        if (!step_block(run, end))
            return FAILED;
        if (time(NULL) != second)
            return PAUSED;
    }
    if (run->done < run->n_steps)
        return HALTED;
    MARK_TIME(run->stop);
    FOR_EACH_COMPONENT(c) {
        if (!terminate(run, c))
            return FAILED;
    }
    return FINISHED;
}

enum Outcome advance(Run *run) {
    PLAIN_HERE;
    keep_time(&run->t);
    const enum Outcome outcome = go_on(run);
    keep_time(NULL);
    return outcome;
}
