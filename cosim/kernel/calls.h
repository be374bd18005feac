/* What is asked of an FMU while it runs: one function each, whatever its FMI version.
 * Each returns false after it has written down in the Run what failed. */
#ifndef COSIM_CALLS_H
#define COSIM_CALLS_H

#include "arithmetic.h"
#include "kernel.h"
#include "mark.h"
#include <math.h>

#define LIKELY(condition) __builtin_expect(condition, 1)
#define UNLIKELY(condition) __builtin_expect(condition, 0)
#define INLINE static inline __attribute__((always_inline))
#define TRY(action)                                                                                \
    if (UNLIKELY(!(action)))                                                                       \
    return false

__attribute__((cold, noinline, unused)) static bool fail(Run *run, const Component *c,
                                                         const char *call, int status) {
    run->failed = c - run->components;
    run->call = call;
    run->status = status;
    take_stray(c->log);
    if (status == fmi2Fatal) /* nothing may be called on it any more, not even to free it */
        run->components[run->failed].instance = NULL;
    return false;
}

__attribute__((cold, noinline, unused)) static bool refuse(Run *run, const Component *c,
                                                           const char *call, int status) {
    const unsigned last = c->version == 2 ? (unsigned)fmi2Pending : (unsigned)fmi3Fatal;
    if ((unsigned)status > last && status != c->log->reason) {
        c->log->unknown = status;
        status = UNKNOWN_STATUS;
    }
    return fail(run, c, call, status);
}

/* A call that answered anything but OK, or left another arithmetic. Statuses from OK to fatal are
 * the same numbers in both versions. */
__attribute__((cold, noinline, unused)) static bool accepted(Run *run, const Component *c,
                                                             const char *call, int status) {
    restore_sums();
    if ((unsigned)status > fmi2Warning)
        return refuse(run, c, call, status);
    if (status == fmi2Warning)
        note_warning(c->log, call, run->t);
    return true;
}

/* One look at both: each further branch of nine calls is seen in a step of some nanoseconds. */
INLINE bool passed(Run *run, const Component *c, const char *call, int status) {
    return LIKELY(((unsigned)status | wrong_sums()) == 0) || accepted(run, c, call, status);
}

/* The same, before another call of the same component. */
INLINE bool answered(Run *run, const Component *c, const char *call, int status) {
    return LIKELY(status == fmi2OK) || accepted(run, c, call, status);
}

INLINE bool plain(bool done) {
    restore_sums();
    return done;
}

#define CALL_OF(run, c, version, name)                                                             \
    (MARK(c, "fmi" #version #name),                                                                \
     passed(run, c, "fmi" #version #name, (int)(c)->call.fmi##version.name((c)->instance)))
#define CALL(run, c, name) ((c)->version == 2 ? CALL_OF(run, c, 2, name) : CALL_OF(run, c, 3, name))

INLINE bool set(Run *run, const Component *c, int version, const uint32_t *references, size_t n,
                const double *values) {
    if (LIKELY(version == 2)) {
        MARK(c, "fmi2SetReal");
        const fmi2Status status = c->call.fmi2.SetReal(c->instance, references, n, values);
        return answered(run, c, "fmi2SetReal", (int)status);
    }
    MARK(c, "fmi3SetFloat64");
    const fmi3Status status = c->call.fmi3.SetFloat64(c->instance, references, n, values, n);
    return answered(run, c, "fmi3SetFloat64", (int)status);
}

INLINE bool get(Run *run, const Component *c, int version, const uint32_t *references, size_t n,
                double *values) {
    if (LIKELY(version == 2)) {
        MARK(c, "fmi2GetReal");
        const fmi2Status status = c->call.fmi2.GetReal(c->instance, references, n, values);
        return passed(run, c, "fmi2GetReal", (int)status);
    }
    MARK(c, "fmi3GetFloat64");
    const fmi3Status status = c->call.fmi3.GetFloat64(c->instance, references, n, values, n);
    return passed(run, c, "fmi3GetFloat64", (int)status);
}

/* A step of FMI 3.0 that answered anything but OK, or that it has come to its end. */
__attribute__((cold, noinline, unused)) static bool went_on(Run *run, const Component *c,
                                                            int status) {
    const Answers *answers = &run->answers;
    if ((answers->terminate || answers->early) && (unsigned)status <= fmi3Warning)
        return fail(run, c, "fmi3DoStep", answers->terminate ? TERMINATED : RETURNED_EARLY);
    return accepted(run, c, "fmi3DoStep", status);
}

/* final: no step begins before its end again. */
INLINE bool do_step_over(Run *run, const Component *c, int version, double t, double h,
                         bool final) {
    MARK_TIME(t);
    if (LIKELY(version == 2)) {
        MARK(c, "fmi2DoStep");
        const fmi2Status status = c->call.fmi2.DoStep(c->instance, t, h, final);
        return passed(run, c, "fmi2DoStep", (int)status);
    }
    /* Event mode is not used, so the FMU handles its events itself, whatever it says here. */
    Answers *answers = &run->answers;
    MARK(c, "fmi3DoStep");
    const fmi3Status status =
        c->call.fmi3.DoStep(c->instance, t, h, final, &answers->event_handling_needed,
                            &answers->terminate, &answers->early, &answers->last_successful_time);
    const unsigned ended = (unsigned)answers->terminate | (unsigned)answers->early;
    return LIKELY(((unsigned)status | wrong_sums() | ended) == 0) || went_on(run, c, (int)status);
}

INLINE bool do_step(Run *run, const Component *c, int version) {
    return do_step_over(run, c, version, run->t, run->h, true);
}

__attribute__((noinline, unused)) static const double *gather_any(const Component *c,
                                                                  const double *row) {
    for (size_t i = 0; i < c->n_inputs; i++)
        c->gathered[i] = row[c->input_offsets[i]];
    for (size_t i = 0; c->scales && i < c->n_inputs; i++)
        c->gathered[i] = c->scales[i] * c->gathered[i] + c->scales[c->n_inputs + i];
    return c->gathered;
}

/* Two are common, and a loop that short costs more than what it does. */
INLINE const double *gather(const Component *c, const double *row) {
    if (LIKELY(c->inputs == PAIR)) {
        c->gathered[0] = row[c->input_offsets[0]];
        c->gathered[1] = row[c->input_offsets[1]];
        return c->gathered;
    }
    return gather_any(c, row);
}

/* Of a component that has some. Its next call makes the arithmetic plain again; before a call of
 * another component, plain() has to. */
INLINE bool set_some_inputs(Run *run, const Component *c, int version, const double *row) {
    const double *values =
        LIKELY(c->inputs == SIDE_BY_SIDE) ? row + c->input_offset : gather(c, row);
    return set(run, c, version, c->input_references, c->n_inputs, values);
}

INLINE bool set_inputs(Run *run, const Component *c, const double *row) {
    return UNLIKELY(c->inputs == NONE) || plain(set_some_inputs(run, c, c->version, row));
}

/* Of a component that has some. */
INLINE bool get_some_outputs(Run *run, const Component *c, int version, size_t n, double *row) {
    return get(run, c, version, c->output_references, n, row + c->column);
}

INLINE bool get_outputs(Run *run, const Component *c, size_t n, double *row) {
    return UNLIKELY(n == 0) || get_some_outputs(run, c, c->version, n, row);
}

INLINE bool reset(Run *run, const Component *c) { return CALL(run, c, Reset); }

INLINE bool set_values(Run *run, const Component *c, const Setting *s) {
    MARK(c, "");
    MARK_CALL(s->call);
    const int status = c->version == 2
                           ? (int)s->set.fmi2(c->instance, s->references, s->n, s->values)
                           : (int)s->set.fmi3(c->instance, s->references, s->n, s->values, s->n);
    return passed(run, c, s->call, status);
}

INLINE bool set_start_values(Run *run, const Component *c, bool late) {
    for (size_t i = 0; i < c->n_settings; i++) {
        const Setting *s = &c->settings[i];
        TRY((s->late != 0) != late || set_values(run, c, s));
    }
    return true;
}

INLINE bool enter_initialization(Run *run, const Component *c) {
    const bool has_tolerance = c->tolerance > 0.0, has_stop = isfinite(run->stop);
    if (LIKELY(c->version == 2)) {
        MARK(c, "fmi2SetupExperiment");
        const fmi2Status status = c->call.fmi2.SetupExperiment(
            c->instance, has_tolerance, c->tolerance, run->start, has_stop, run->stop);
        TRY(passed(run, c, "fmi2SetupExperiment", (int)status) && set_start_values(run, c, false) &&
            CALL_OF(run, c, 2, EnterInitializationMode));
    } else {
        TRY(set_start_values(run, c, false));
        MARK(c, "fmi3EnterInitializationMode");
        TRY(passed(run, c, "fmi3EnterInitializationMode",
                   (int)c->call.fmi3.EnterInitializationMode(
                       c->instance, has_tolerance, c->tolerance, run->start, has_stop, run->stop)));
    }
    return set_start_values(run, c, true);
}

INLINE bool exit_initialization(Run *run, const Component *c) {
    return CALL(run, c, ExitInitializationMode);
}

INLINE bool terminate(Run *run, const Component *c) { return CALL(run, c, Terminate); }

#endif
