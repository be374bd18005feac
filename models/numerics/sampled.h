/* A model that does nothing between its samples: what a model.c includes after its function
 * sample(w, u, p), which takes one. Its memory has k, the number of the next sample. */
#include <stddef.h>

#include "model.h"
#include "numerics/sampling.h"

bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    if (!samples_countable(w->k, p->T_s, t + h))
        return false;
    for (; sample_due(w->k, p->T_s, t + h); w->k += 1.0)
        sample(w, u, p);
    const double *all = (const double *)w;
    double sum = 0.0;
    for (size_t i = 0; i < sizeof *w / sizeof *all; i++)
        sum += all[i];
    return sum - sum == 0.0; /* finite */
}

double model_sample(double t, Memory *w, const Inputs *u, const Parameters *p) {
    for (; samples_countable(w->k, p->T_s, t) && sample_reached(w->k, p->T_s, t); w->k += 1.0)
        sample(w, u, p);
    return w->k * p->T_s;
}
