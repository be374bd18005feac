/* What is kept of the rows. */
#ifndef COSIM_RECORD_H
#define COSIM_RECORD_H

#include "calls.h"

/* Of the rows from first to last, those of every n-th step. */
static inline void record_rows(const Run *run, int64_t first, int64_t last) {
    const int64_t begin = (first + run->every - 1) / run->every, end = last / run->every + 1;
    const int64_t stride = run->every * run->width;
    if (!run->record || begin >= end) {
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

INLINE void add_square(SumOfSquares *sum, int64_t n, double value, double reference) {
    if (LIKELY(n >= sum->first && n < sum->end)) {
        const double deviation = value - reference;
        sum->sum += deviation * deviation;
    }
}

/* Of the row of step n. There is one sum, if any, before there are many. */
INLINE void add_squares(Run *run, int64_t n, const double *row) {
    SumOfSquares *s = run->sums, *end = s + run->n_sums;
    if (s == end) {
        return;
    }
    do {
        add_square(s, n, row[s->column], s->reference < 0 ? s->constant : row[s->reference]);
    } while (UNLIKELY(++s != end));
}

#endif
