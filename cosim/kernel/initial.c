/* Outputs that depend on inputs that depend on outputs, in initialisation mode: set and get until
 * all agree. */
#include "calls.h"
#include "coupling.h"
#include "disturbance.h"
#include <string.h>

/* Rows 0 and 1 are the same point in time. */
static bool sweep(Run *run, Loop *loop) {
    double *next = run->rows + run->width;
    for (int64_t j = 0; j < loop->n; j++) {
        next[loop->columns[j]] = run->rows[loop->columns[j]];
    }
    for (int64_t i = loop->first; i < loop->end; i++) {
        const Component *c = &run->components[i];
        double *values = run->rows + c->column;
        if (!(set_inputs(run, c, run->rows) && get_outputs(run, c, c->n_linked, run->rows))) {
            return false;
        }
        disturb(run, c, run->rows, 0);
        memcpy(values + run->width, values, c->n_linked * sizeof *values);
    }
    return true;
}

bool solve_initial(Run *run) {
    run->initial->known = false;
    return solve(run, run->initial, run->rows, sweep);
}
