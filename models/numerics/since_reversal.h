/* Displacement since the last reversal, for models whose memory has q and direction, and whose
 * parameters have T_s. */
#ifndef SINCE_REVERSAL_H
#define SINCE_REVERSAL_H

#include "variables.h"

/* Go on by a period with the mean velocity v; returns the displacement [m] in its middle. */
static inline double since_reversal(Memory *w, double v, const Parameters *p) {
    const double direction = v > 0.0 ? 1.0 : v < 0.0 ? -1.0 : w->direction;
    if (direction != w->direction)
        w->q = 0.0;
    w->direction = direction;
    const double way = v * direction * p->T_s, middle = w->q + 0.5 * way;
    w->q += way;
    return middle;
}

#endif
