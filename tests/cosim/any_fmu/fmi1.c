/* FMI 1.0 Co-Simulation: x' = u while `on`, y = x + k u, and `high` tells whether y is above 1. */
#include <stddef.h>
/* fmi1Functions.h needs it */
#include <fmi1Functions.h>
#include <stdlib.h>

#pragma GCC diagnostic ignored "-Wunused-parameter"
#define SHOWN __attribute__((visibility("default")))
#define NAME(function) old_fmi##function

enum { U, K, X, Y, N_REALS };
typedef struct {
    double r[N_REALS];
    char on;
} Model;

static void evaluate(Model *m) { m->r[Y] = m->r[X] + m->r[K] * m->r[U]; }

SHOWN fmi1Component NAME(InstantiateSlave)(fmi1String name, fmi1String guid, fmi1String location,
                                           fmi1String mime, fmi1Real timeout, fmi1Boolean visible,
                                           fmi1Boolean interactive, fmi1CallbackFunctions functions,
                                           fmi1Boolean logging) {
    Model *m = functions.allocateMemory(1, sizeof *m);
    m->r[K] = 1.0;
    m->on = 1;
    return m;
}
SHOWN void NAME(FreeSlaveInstance)(fmi1Component c) { free(c); }
SHOWN fmi1Status NAME(InitializeSlave)(fmi1Component c, fmi1Real t, fmi1Boolean ends,
                                       fmi1Real stop) {
    evaluate(c); /* with the values set before, and not again until a step is done */
    return t < stop ? fmi1OK : fmi1Error;
}
SHOWN fmi1Status NAME(TerminateSlave)(fmi1Component c) { return fmi1OK; }
SHOWN fmi1Status NAME(ResetSlave)(fmi1Component c) {
    *(Model *)c = (Model){.r[K] = 1.0, .on = 1};
    return fmi1OK;
}
SHOWN fmi1Status NAME(DoStep)(fmi1Component c, fmi1Real t, fmi1Real h, fmi1Boolean new_step) {
    Model *m = c;
    m->r[X] += m->on ? h * m->r[U] : 0.0;
    evaluate(m);
    return fmi1OK;
}
SHOWN fmi1Status NAME(SetReal)(fmi1Component c, const unsigned r[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++)
        ((Model *)c)->r[r[i]] = v[i];
    return fmi1OK;
}
SHOWN fmi1Status NAME(GetReal)(fmi1Component c, const unsigned r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++)
        v[i] = ((Model *)c)->r[r[i]];
    return fmi1OK;
}
SHOWN fmi1Status NAME(SetBoolean)(fmi1Component c, const unsigned r[], size_t n, const char v[]) {
    ((Model *)c)->on = v[n - 1];
    return fmi1OK;
}
SHOWN fmi1Status NAME(GetBoolean)(fmi1Component c, const unsigned r[], size_t n, char v[]) {
    for (size_t i = 0; i < n; i++)
        v[i] = ((Model *)c)->r[Y] > 1.0;
    return fmi1OK;
}

#define ABSENT(name)                                                                               \
    SHOWN fmi1Status NAME(name)(void) { return fmi1Error; }
ABSENT(SetInteger)
ABSENT(GetInteger)
ABSENT(SetString)
ABSENT(GetString)
ABSENT(SetRealInputDerivatives)
ABSENT(GetRealOutputDerivatives)
ABSENT(CancelStep)
ABSENT(GetStatus)
ABSENT(GetRealStatus)
ABSENT(GetIntegerStatus)
ABSENT(GetBooleanStatus)
ABSENT(GetStringStatus)
ABSENT(SetDebugLogging)
SHOWN const char *NAME(GetTypesPlatform)(void) { return "standard32"; }
SHOWN const char *NAME(GetVersion)(void) { return "1.0"; }
