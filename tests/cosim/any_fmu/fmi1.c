/* FMI 1.0: x' = u while `on`, y = x + k u, and `high` tells whether y is at least 1. In Model
 * Exchange x jumps by 1 at 0.25 s, and `high` is set by events. */
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
    char on, high;
    double t;
    int jumped;
} Model;

static void evaluate(Model *m) {
    m->r[Y] = m->r[X] + m->r[K] * m->r[U];
    m->high = m->r[Y] >= 1.0;
}

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
        v[i] = ((Model *)c)->high;
    return fmi1OK;
}

SHOWN fmi1Component NAME(InstantiateModel)(fmi1String name, fmi1String guid,
                                           fmi1CallbackFunctions functions, fmi1Boolean logging) {
    return NAME(InstantiateSlave)(name, guid, "", "", 0.0, 0, 0, functions, logging);
}
SHOWN void NAME(FreeModelInstance)(fmi1Component c) { free(c); }
SHOWN fmi1Status NAME(EventUpdate)(fmi1Component c, fmi1Boolean steps, fmi1EventInfo *info) {
    Model *m = c;
    const int jumps = !m->jumped && m->t >= 0.25;
    m->jumped |= jumps;
    m->r[X] += jumps;
    evaluate(m);
    *info = (fmi1EventInfo){1, 0, (fmi1Boolean)jumps, 0, !m->jumped, 0.25};
    return fmi1OK;
}
SHOWN fmi1Status NAME(Initialize)(fmi1Component c, fmi1Boolean controlled, fmi1Real tolerance,
                                  fmi1EventInfo *info) {
    return NAME(EventUpdate)(c, 0, info);
}
SHOWN fmi1Status NAME(Terminate)(fmi1Component c) { return fmi1OK; }
SHOWN fmi1Status NAME(SetTime)(fmi1Component c, fmi1Real t) {
    ((Model *)c)->t = t;
    return fmi1OK;
}
SHOWN fmi1Status NAME(SetContinuousStates)(fmi1Component c, const double x[], size_t n) {
    Model *m = c;
    m->r[X] = x[n - 1];
    m->r[Y] = m->r[X] + m->r[K] * m->r[U];
    return fmi1OK;
}
SHOWN fmi1Status NAME(GetContinuousStates)(fmi1Component c, double x[], size_t n) {
    x[n - 1] = ((Model *)c)->r[X];
    return fmi1OK;
}
SHOWN fmi1Status NAME(GetNominalContinuousStates)(fmi1Component c, double x[], size_t n) {
    x[n - 1] = 1.0;
    return fmi1OK;
}
SHOWN fmi1Status NAME(GetDerivatives)(fmi1Component c, double dx[], size_t n) {
    Model *m = c;
    dx[n - 1] = m->on ? m->r[U] : 0.0;
    return fmi1OK;
}
SHOWN fmi1Status NAME(GetEventIndicators)(fmi1Component c, double z[], size_t n) {
    Model *m = c;
    z[n - 1] = m->r[X] + m->r[K] * m->r[U] - 1.0;
    return fmi1OK;
}
SHOWN fmi1Status NAME(CompletedIntegratorStep)(fmi1Component c, fmi1Boolean *update) {
    *update = 0;
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
ABSENT(GetStateValueReferences)
SHOWN const char *NAME(GetTypesPlatform)(void) { return "standard32"; }
SHOWN const char *NAME(GetModelTypesPlatform)(void) { return "standard32"; }
SHOWN const char *NAME(GetVersion)(void) { return "1.0"; }
