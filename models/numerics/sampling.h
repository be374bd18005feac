/* Sample instants k T_s of a model with its own period, whatever step its tool takes. */
#ifndef SAMPLING_H
#define SAMPLING_H

#include <stdbool.h>

#include "numerics/elementary.h"

/* Is sample k due before time `end`? A part in 1e6 of T_s absorbs the rounding of other clocks. */
static inline bool sample_due(double k, double T_s, double end) {
    return k * T_s < end - 1e-6 * T_s;
}

/* Has the time t of sample k come? The same part absorbs the rounding of t. */
static inline bool sample_reached(double k, double T_s, double t) {
    return k * T_s <= t + 1e-6 * T_s;
}

/* Can the samples from k to time `end` be taken in one call? Ten million take seconds; beyond 2^51
 * there is no next whole number. */
static inline bool samples_countable(double k, double T_s, double end) {
    return k > -0x1p51 && k < 0x1p51 && end - k * T_s <= 1e7 * T_s;
}

/* Number of the first sample at or after time t. */
static inline double first_sample(double t, double T_s) {
    const double k = nearest(t / T_s);
    return k + (sample_due(k, T_s, t) ? 1.0 : 0.0);
}

#endif
