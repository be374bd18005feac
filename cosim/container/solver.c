/* The solver of Model Exchange: FMPy's libraries of CVode, from the resources. */
#include "inside.h"
#include "library.h"
#include <stdio.h>
#include <string.h>

#if !EXCHANGE
bool solver_load(Instance *x) { return true; }
void solver_unload(Instance *x) {}
#else

/* Each after those that it needs. */
static const char *const LIBRARIES[N_SOLVER] = {"core", "nvecserial", "sunmatrixdense",
                                                "sunlinsoldense", "cvode"};

static bool find(Instance *x, const char *name, void *function, size_t size) {
    void (*found)(void) = NULL;
    for (int i = 0; !found && i < N_SOLVER; i++) {
        found = library_function(x->solver[i], name);
    }
    memcpy(function, &found, size);
    if (!found) {
        report(x, ERROR, "the solver of Model Exchange lacks the function %s", name);
    }
    return found != NULL;
}

#define FIND(result, name, arguments) &&find(x, #name, &x->cvode.name, sizeof x->cvode.name)

bool solver_load(Instance *x) {
    char path[4096], reason[1024];
    for (int i = 0; i < N_SOLVER; i++) {
        snprintf(path, sizeof path, "%s/cvode/" FOLDER3 "/sundials_%s" SUFFIX, x->resources,
                 LIBRARIES[i]);
        x->solver[i] = library_open(path, reason, sizeof reason);
        if (!x->solver[i]) {
            report(x, ERROR, "the solver of Model Exchange cannot be loaded: %s", reason);
            return false;
        }
    }
    return true CVODE_CALLS(FIND);
}

/* The last first: each needs those before it. */
void solver_unload(Instance *x) {
    for (int i = N_SOLVER - 1; i >= 0; i--) {
        if (x->solver[i]) {
            library_close(x->solver[i]);
        }
    }
}
#endif
