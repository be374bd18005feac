/* From one point in time to the next, whatever a step is. */
#ifndef COSIM_WALK_H
#define COSIM_WALK_H

#include "calls.h"
#include "record.h"

/* Read inputs from row now and, where they are fresh, from row next; write outputs to row next. */
typedef bool Step(Run *run, const double *now, double *next);

/* Take the row of step n into the sums. */
typedef void Add(Run *run, int64_t n, const double *row);

INLINE bool walk(Run *run, int64_t end, Step step_all, Add add, int64_t width, bool constant) {
    double *now = row_of(run, run->done);
    run->h = run->step;
    for (int64_t n = run->done; n < end; now += width) {
        run->t = run->start + (double)n * run->step;
        if (!constant) {
            run->h = run->start + (double)(n + 1) * run->step - run->t;
        }
        TRY(step_all(run, now, now + width));
        add(run, ++n, now + width);
        run->done = n;
    }
    return true;
}

#endif
