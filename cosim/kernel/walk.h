/* From one point in time to the next, whatever a step is. */
#ifndef COSIM_WALK_H
#define COSIM_WALK_H

#include "calls.h"
#include <string.h>

/* Read inputs from row now and, where they are fresh, from row next; write outputs to row next. */
typedef bool Step(Run *run, const double *now, double *next);

/* Find the next input event, from a step on. */
static inline void seek_event(Run *run, int64_t step) {
    while (run->event < run->n_events && run->events[run->event].step < step) {
        run->event++;
    }
    run->event_end = run->event < run->n_events ? run->events[run->event].step + 1 : 0;
}

/* One step in parts, from input event to input event, in rows of their own. */
__attribute__((cold, noinline, unused)) static bool
step_in_parts(Run *run, const double *now, double *next, double t_next, Step step_all) {
    const size_t width = (size_t)run->width, n_external = (size_t)run->n_external;
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

INLINE bool walk(Run *run, int64_t end, Step step_all) {
    const int64_t width = run->width;
    double *now = row_of(run, run->done);
    for (; run->done < end; run->done++) {
        double *next = now + width;
        const double t_next = run->start + (double)(run->done + 1) * run->step;
        run->t = run->start + (double)run->done * run->step;
        run->h = run->constant_step ? run->step : t_next - run->t;
        TRY(UNLIKELY(run->done + 1 == run->event_end)
                ? step_in_parts(run, now, next, t_next, step_all)
                : step_all(run, now, next));
        now = next;
    }
    return true;
}

#endif
