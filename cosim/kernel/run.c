#include "calls.h"
#include "disturbance.h"
#include <string.h>
#include <time.h>

#define FOR_EACH_COMPONENT(c) for (Component *c = run->components; c->version; c++)
#define TRY(action)                                                                                \
    if (UNLIKELY(!(action)))                                                                       \
    return false

/* Before the first step rows 0 and 1 are the same point in time: a fresh input reads the latter. */
static bool get_initial(Run *run, const Component *c) {
    double *values = run->rows + c->column;
    TRY(get_outputs(run, c, c->n_linked, run->rows));
    disturb(run, c, run->rows, 0);
    memcpy(values + run->width, values, c->n_linked * sizeof *values);
    return true;
}

static bool initialise(Run *run) {
    memcpy(run->rows, run->external, (size_t)run->n_external * sizeof *run->rows);
    FOR_EACH_COMPONENT(c) {
        c->log->severity = 0;
        c->log->message[0] = '\0';
        TRY(!c->used || reset(run, c));
        c->used = 1;
        TRY(enter_initialization(run, c));
    }
    FOR_EACH_COMPONENT(c) { TRY(get_initial(run, c)); }
    FOR_EACH_COMPONENT(c) { TRY(set_inputs(run, c, run->rows) && get_initial(run, c)); }
    FOR_EACH_COMPONENT(c) { TRY(exit_initialization(run, c)); }
    FOR_EACH_COMPONENT(c) {
        TRY(get_outputs(run, c, c->n_outputs, run->rows));
        disturb(run, c, run->rows, 0);
    }
    return true;
}

/* Written out four times, each with a call instruction of its own: where components share one, the
 * processor keeps guessing wrong which FMU it leads to, and a step costs up to twice as much. */
#define NEXT(c, action)                                                                            \
    if (UNLIKELY(!c->version)) {                                                                   \
        break;                                                                                     \
    }                                                                                              \
    TRY(action);                                                                                   \
    c++
#define ALL_IN_TURN(c, action)                                                                     \
    for (const Component *c = run->components;;) {                                                 \
        NEXT(c, action);                                                                           \
        NEXT(c, action);                                                                           \
        NEXT(c, action);                                                                           \
        NEXT(c, action);                                                                           \
    }

INLINE bool step_one_by_one(Run *run, double *now, double t, double h) {
    ALL_IN_TURN(c, set_inputs(run, c, now) && do_step(run, c, t, h) &&
                       get_outputs(run, c, c->n_outputs, now + run->width));
    return true;
}

INLINE bool step_all_at_once(Run *run, double *now, double t, double h) {
    ALL_IN_TURN(c, set_inputs(run, c, now));
    ALL_IN_TURN(c, do_step(run, c, t, h));
    ALL_IN_TURN(c, get_outputs(run, c, c->n_outputs, now + run->width));
    return true;
}

/* As the two above, with what the scenario does to the outputs. */
static bool step_disturbed(Run *run, double *now, double t, double h) {
    double *next = now + run->width;
    if (!run->jacobi) {
        FOR_EACH_COMPONENT(c) {
            TRY(set_inputs(run, c, now) && do_step(run, c, t, h) &&
                get_outputs(run, c, c->n_outputs, next));
            disturb(run, c, next, run->done + 1);
        }
        return true;
    }
    TRY(step_all_at_once(run, now, t, h));
    FOR_EACH_COMPONENT(c) { disturb(run, c, next, run->done + 1); }
    return true;
}

/* The row of step n. All rows are kept, or those of one block, which the next block overwrites. */
static inline double *row_of(const Run *run, int64_t n) {
    return run->rows + (run->record ? n - run->block_start : n) * run->width;
}

static bool step(Run *run) {
    const int64_t n = run->done;
    const double t = run->start + (double)n * run->step;
    const double t_next = run->start + (double)(n + 1) * run->step;
    const double h = run->constant_step ? run->step : t_next - t;
    double *now = row_of(run, n);
    if (UNLIKELY(run->disturbed)) {
        return step_disturbed(run, now, t, h);
    }
    return run->jacobi ? step_all_at_once(run, now, t, h) : step_one_by_one(run, now, t, h);
}

/* The exponent of a double that is not finite has all bits set: one more and it overflows. */
static inline uint64_t overflow(double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return ((bits >> 52 & 0x7ff) + 1) & 0x800;
}

/* Look at the outputs in row n of the components before end; blame the first that is not finite. */
static bool finite(Run *run, int64_t n, const Component *end) {
    const double *row = row_of(run, n);
    for (const Component *c = run->components; c->version && c != end; c++) {
        for (size_t i = 0; i < c->n_outputs; i++) {
            if (overflow(row[c->column + (int64_t)i])) {
                run->done = n - 1;
                run->output = (int64_t)i;
                return fail(run, c, c->version == 2 ? "fmi2GetReal" : "fmi3GetFloat64", NOT_FINITE);
            }
        }
    }
    return true;
}

/* A step failed. Where a value before it was not finite, that one is to blame. */
static void trace_back(Run *run, int64_t first) {
    const int64_t last = run->done;
    const Component *failed = run->components + run->failed;
    for (int64_t n = first; n <= last; n++) {
        if (!finite(run, n, NULL)) {
            return;
        }
    }
    if (!run->jacobi) {
        finite(run, last + 1, failed);
    }
}

/* Check rows first .. last, and copy what is recorded of them. */
static bool close_rows(Run *run, int64_t first, int64_t last) {
    const double *values = row_of(run, first);
    const int64_t n_values = (last - first + 1) * run->width;
    uint64_t overflows = 0;
    for (int64_t i = 0; i < n_values; i++) {
        overflows |= overflow(values[i]);
    }
    for (int64_t n = first; overflows && n <= last; n++) {
        TRY(finite(run, n, NULL));
    }
    for (int64_t n = first; run->record && n <= last; n++) {
        const double *row = row_of(run, n);
        double *record = run->record + n * run->n_selected;
        for (int64_t i = 0; i < run->n_selected; i++) {
            record[i] = row[run->selected[i]];
        }
    }
    return true;
}

static bool step_block(Run *run, int64_t end) {
    const int64_t first = run->done;
    if (run->record) {
        memmove(run->rows, row_of(run, first), (size_t)run->width * sizeof(double));
        run->block_start = first;
    }
    for (int64_t n = first; n <= end; n++) {
        memcpy(row_of(run, n), run->external + n * run->n_external,
               (size_t)run->n_external * sizeof(double));
    }
    for (; run->done < end; run->done++) {
        if (UNLIKELY(!step(run))) {
            trace_back(run, first + 1);
            return false;
        }
    }
    return close_rows(run, first + 1, end);
}

enum Outcome advance(Run *run) {
    if (run->done < 0) {
        run->block_start = 0;
        if (!initialise(run) || !close_rows(run, 0, 0)) {
            return FAILED;
        }
        run->done = 0;
    }
    const time_t second = time(NULL);
    while (run->done < run->halt) {
        const int64_t left = run->halt - run->done;
        if (!step_block(run, run->done + (left < run->block ? left : run->block))) {
            return FAILED;
        }
        if (time(NULL) != second) {
            return PAUSED;
        }
    }
    if (run->done < run->n_steps) {
        return HALTED;
    }
    FOR_EACH_COMPONENT(c) {
        if (!terminate(run, c)) {
            return FAILED;
        }
    }
    return FINISHED;
}
