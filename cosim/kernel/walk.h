/* From one point in time to the next, whatever a step is. */
#ifndef COSIM_WALK_H
#define COSIM_WALK_H

#include "calls.h"

/* Read inputs from row now and, where they are fresh, from row next; write outputs to row next. */
typedef bool Step(Run *run, const double *now, double *next);

INLINE bool walk(Run *run, int64_t end, Step step_all) {
    const int64_t width = run->width;
    double *now = row_of(run, run->done);
    for (; run->done < end; run->done++) {
        double *next = now + width;
        const double t_next = run->start + (double)(run->done + 1) * run->step;
        run->t = run->start + (double)run->done * run->step;
        run->h = run->constant_step ? run->step : t_next - run->t;
        TRY(step_all(run, now, next));
        now = next;
    }
    return true;
}

#endif
