/* How much of an observer's force acts, for models that name numerics/onset.toml under `include`.
 */
#ifndef ONSET_H
#define ONSET_H

#include "numerics/since_reversal.h"

/* 0 until the reference has moved by the onset since its last rest or reversal, 1 from twice that
 * on. It rests while it would take a second and more for that way. */
static inline double onset(Memory *w, double v_r, const Parameters *p) {
    since_reversal(w, v_r, p);
    if (v_r < p->onset && -v_r < p->onset)
        w->q = 0.0;
    const double share = p->onset > 0.0 ? w->q / p->onset - 1.0 : 1.0;
    return share < 0.0 ? 0.0 : share > 1.0 ? 1.0 : share;
}

#endif
