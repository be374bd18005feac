/* Back to the begin of a step: the states of FMUs, saved and restored. */
#include "calls.h"
#include "coupling.h"
#include <math.h>

#define NAME(c, fmi2, fmi3) ((c)->version == 2 ? fmi2 : fmi3)

bool save(Run *run, int64_t first, int64_t end) {
    for (int64_t i = first; i < end; i++) {
        const Component *c = &run->components[i];
        Member *m = &run->coupling->members[i];
        const char *call = NAME(c, "fmi2GetFMUstate", "fmi3GetFMUState");
        MARK(c, "");
        MARK_CALL(call);
        TRY(passed(run, c, call, m->save(c->instance, &m->state)));
        TRY(m->state || fail(run, c, call, NO_STATE));
        TRY(m->proven || c->n_outputs == 0 ||
            get(run, c, c->version, c->output_references, c->n_outputs, m->outputs));
    }
    return true;
}

/* An FMU that does not come back to where it was is noticed by its outputs, which are looked at
 * until they were elsewhere and came back once. */
static bool came_back(Run *run, const Component *c, Member *m) {
    const double *moved = run->coupling->next + c->column;
    TRY(get(run, c, c->version, c->output_references, c->n_outputs, m->again));
    for (size_t i = 0; i < c->n_outputs; i++) {
        const double size =
            fmax(fabs(m->outputs[i]), run->coupling->nominal[c->column + (int64_t)i]);
        if (fabs(m->again[i] - m->outputs[i]) > 1e-6 * size) {
            run->output = (int64_t)i;
            return fail(run, c, NAME(c, "fmi2SetFMUstate", "fmi3SetFMUState"), RESTORED_WRONGLY);
        }
        m->proven = m->proven || fabs(moved[i] - m->outputs[i]) > 1e-6 * size;
    }
    return true;
}

bool restore(Run *run, int64_t first, int64_t end) {
    for (int64_t i = first; i < end; i++) {
        const Component *c = &run->components[i];
        Member *m = &run->coupling->members[i];
        MARK(c, "");
        MARK_CALL(NAME(c, "fmi2SetFMUstate", "fmi3SetFMUState"));
        const int status = m->restore(c->instance, m->state);
        TRY(passed(run, c, NAME(c, "fmi2SetFMUstate", "fmi3SetFMUState"), status));
        TRY(m->proven || c->n_outputs == 0 || came_back(run, c, m));
    }
    return true;
}

void forget(Run *run) {
    PLAIN_HERE;
    for (int64_t i = 0; run->coupling && i < run->coupling->n_members; i++) {
        Member *m = &run->coupling->members[i];
        Component *c = &run->components[i];
        if (m->state && c->instance) {
            MARK(c, "");
            MARK_CALL(NAME(c, "fmi2FreeFMUstate", "fmi3FreeFMUState"));
            c->instance = m->discard(c->instance, &m->state) == fmi2Fatal ? NULL : c->instance;
        }
        m->state = NULL;
    }
}
