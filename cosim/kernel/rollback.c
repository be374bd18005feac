/* Back to the begin of a step: the states of FMUs, saved and restored. */
#include "calls.h"
#include "coupling.h"

#define NAME(c, fmi2, fmi3) ((c)->version == 2 ? fmi2 : fmi3)

bool save(Run *run, int64_t first, int64_t end) {
    for (int64_t i = first; i < end; i++) {
        const Component *c = &run->components[i];
        Member *m = &run->coupling->members[i];
        MARK(c, "");
        MARK_CALL(NAME(c, "fmi2GetFMUstate", "fmi3GetFMUState"));
        const int status = m->save(c->instance, &m->state);
        if (!passed(run, c, NAME(c, "fmi2GetFMUstate", "fmi3GetFMUState"), status)) {
            return false;
        }
    }
    return true;
}

bool restore(Run *run, int64_t first, int64_t end) {
    for (int64_t i = first; i < end; i++) {
        const Component *c = &run->components[i];
        const Member *m = &run->coupling->members[i];
        MARK(c, "");
        MARK_CALL(NAME(c, "fmi2SetFMUstate", "fmi3SetFMUState"));
        const int status = m->restore(c->instance, m->state);
        if (!passed(run, c, NAME(c, "fmi2SetFMUstate", "fmi3SetFMUState"), status)) {
            return false;
        }
    }
    return true;
}

void forget(Run *run) {
    for (int64_t i = 0; run->coupling && i < run->coupling->n_members; i++) {
        Member *m = &run->coupling->members[i];
        if (m->state && run->components[i].instance) {
            MARK(&run->components[i], "");
            MARK_CALL(NAME(&run->components[i], "fmi2FreeFMUstate", "fmi3FreeFMUState"));
            m->discard(run->components[i].instance, &m->state);
        }
        m->state = NULL;
    }
}
