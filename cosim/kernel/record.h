/* What is kept of the rows. */
#ifndef COSIM_RECORD_H
#define COSIM_RECORD_H

#include "kernel.h"

/* Of rows first .. last, those of every so many steps. */
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

static inline void add_squares(const Run *run, SumOfSquares *s, int64_t first, int64_t last) {
    const int64_t begin = first > s->first ? first : s->first;
    const int64_t end = last < s->end ? last + 1 : s->end;
    if (begin >= end) {
        return;
    }
    const bool varies = s->reference >= 0;
    const int64_t width = run->width, stride = varies ? width : 0;
    const double *value = row_of(run, begin) + s->column;
    const double *reference = varies ? row_of(run, begin) + s->reference : &s->constant;
    double sum = s->sum;
    for (int64_t n = begin; n < end; n++) {
        const double deviation = *value - *reference;
        sum += deviation * deviation;
        value += width;
        reference += stride;
    }
    s->sum = sum;
}

#endif
