/* From one point in time to the next, whatever a step is. */
#ifndef COSIM_WALK_H
#define COSIM_WALK_H

#include "calls.h"
#include <string.h>

/* Read inputs from row now and, where they are fresh, from row next; write outputs to row next. */
typedef bool Step(Run *run, const double *now, double *next);

/* Find the next input event, from a step on. */
static inline void seek_event(Run *run, int64_t step) {
    while (run->event < run->n_events && run->events[run->event].step < step)
        run->event++;
    run->event_end = run->event < run->n_events ? run->events[run->event].step + 1 : 0;
}

/* One step in parts, from input event to input event, in rows of their own. */
__attribute__((cold, noinline, unused)) static bool step_in_parts(Run *run, const double *now,
                                                                  double *next, Step step_all) {
    const size_t width = (size_t)run->width, n_external = (size_t)run->n_external;
    const double t_next = run->start + (double)(run->done + 1) * run->step;
    double *from = run->parts, *to = from + width;
    memcpy(from, now, width * sizeof *from);
    for (;; run->event++) {
        const InputEvent *event = &run->events[run->event];
        const bool last = run->event == run->n_events || event->step != run->done;
        const double end = last ? t_next : event->t;
        const double *inputs = last ? next : run->event_inputs + run->event * (int64_t)n_external;
        memcpy(to, inputs, n_external * sizeof *to);
        run->h = end - run->t;
        const bool stepped = step_all(run, from, to);
        if (last || !stepped) {
            memcpy(next + n_external, to + n_external, (width - n_external) * sizeof *next);
            seek_event(run, run->done + 1);
            return stepped;
        }
        memcpy(from, to, width * sizeof *from);
        run->t = end;
    }
}

INLINE bool walk_straight(Run *run, int64_t end, Step step_all, int64_t width, bool constant) {
    double *now = row_of(run, run->done);
    run->h = run->step;
    for (int64_t n = run->done; n < end; now += width) {
        run->t = run->start + (double)n * run->step;
        if (!constant)
            run->h = run->start + (double)(n + 1) * run->step - run->t;
        TRY(step_all(run, now, now + width));
        run->done = ++n;
    }
    return true;
}

/* Straight on to the step of the next input event, that one in parts, and on. */
INLINE bool walk(Run *run, int64_t end, Step step_all, int64_t width, bool constant) {
    for (;;) {
        const int64_t next = run->event_end;
        const bool event = UNLIKELY(next != 0) && next <= end;
        TRY(walk_straight(run, event ? next - 1 : end, step_all, width, constant));
        if (LIKELY(!event))
            return true;
        double *now = row_of(run, next - 1);
        run->t = run->start + (double)(next - 1) * run->step;
        TRY(step_in_parts(run, now, now + width, step_all));
        run->done = next;
    }
}

#endif
