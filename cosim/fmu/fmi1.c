/* FMI 1.0 Co-Simulation under the names of FMI 2.0; built once for each FMU, whose functions the
 * importer puts into `calls`.
 *
 * FMI 1.0 initialises in one call, before which inputs and start values are set and after which
 * outputs can be read. It is therefore made when the first value is read or initialisation ends. */
#include <stddef.h>
/* fmi1Functions.h needs it */
#include <fmi1Functions.h>
#include <fmi2Functions.h>
#include <stdbool.h>
#include <stdlib.h>

#ifdef _WIN32
#define SHOWN __declspec(dllexport)
#else
#define SHOWN __attribute__((visibility("default")))
#endif

/* The importer reads these names. */
#define FMI1_CALLS(X)                                                                              \
    X(InstantiateSlave)                                                                            \
    X(InitializeSlave)                                                                             \
    X(TerminateSlave)                                                                              \
    X(ResetSlave)                                                                                  \
    X(FreeSlaveInstance)                                                                           \
    X(DoStep)                                                                                      \
    X(SetRealInputDerivatives)                                                                     \
    X(SetReal)                                                                                     \
    X(SetInteger)                                                                                  \
    X(SetBoolean)                                                                                  \
    X(SetString)                                                                                   \
    X(GetReal)                                                                                     \
    X(GetInteger)                                                                                  \
    X(GetBoolean)                                                                                  \
    X(GetString)

#define FIELD(name) fmi1##name##TYPE *name;
SHOWN struct {
    FMI1_CALLS(FIELD)
} calls;

typedef struct {
    fmi1Component slave;
    double start, stop; /* s */
    bool initialized;
} Instance;

static int initialized(Instance *m) {
    if (m->initialized) {
        return fmi1OK;
    }
    m->initialized = true;
    return (int)calls.InitializeSlave(m->slave, m->start, fmi1True, m->stop);
}

SHOWN fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                    fmi2String location, const fmi2CallbackFunctions *given,
                                    fmi2Boolean visible, fmi2Boolean logging) {
    (void)type;
    /* The first argument of this logger is the instance and not an environment; the rest agrees. */
    const fmi1CallbackFunctions callbacks = {(fmi1CallbackLogger)(void (*)(void))given->logger,
                                             calloc, free, NULL};
    Instance *m = calloc(1, sizeof *m);
    if (m) {
        m->slave = calls.InstantiateSlave(name, guid, location, "application/x-fmu-sharedlibrary",
                                          0.0, (fmi1Boolean)visible, fmi1False, callbacks,
                                          (fmi1Boolean)logging);
    }
    if (m && !m->slave) {
        free(m);
        m = NULL;
    }
    return m;
}

SHOWN void fmi2FreeInstance(fmi2Component c) {
    calls.FreeSlaveInstance(((Instance *)c)->slave);
    free(c);
}

SHOWN fmi2Status fmi2Reset(fmi2Component c) {
    Instance *m = c;
    m->initialized = false;
    return (fmi2Status)calls.ResetSlave(m->slave);
}

SHOWN fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                     fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    Instance *m = c;
    (void)has_tolerance, (void)tolerance, (void)has_stop;
    m->start = start;
    m->stop = stop;
    return fmi2OK;
}

SHOWN fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    (void)c;
    return fmi2OK;
}

SHOWN fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (fmi2Status)initialized(c); }

SHOWN fmi2Status fmi2Terminate(fmi2Component c) {
    return (fmi2Status)calls.TerminateSlave(((Instance *)c)->slave);
}

SHOWN fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final) {
    (void) final;
    return (fmi2Status)calls.DoStep(((Instance *)c)->slave, t, h, fmi1True);
}

SHOWN fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[],
                                             size_t n, const fmi2Integer orders[],
                                             const fmi2Real values[]) {
    return (fmi2Status)calls.SetRealInputDerivatives(((Instance *)c)->slave, r, n, orders, values);
}

/* FMI 1.0 does not tell whether a slave has terminated. */
SHOWN fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

#define VALUES(Type)                                                                               \
    SHOWN fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference r[], size_t n,        \
                                   const fmi2##Type values[]) {                                    \
        return (fmi2Status)calls.Set##Type(((Instance *)c)->slave, r, n, values);                  \
    }                                                                                              \
    SHOWN fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference r[], size_t n,        \
                                   fmi2##Type values[]) {                                          \
        Instance *m = c;                                                                           \
        const int before = initialized(m);                                                         \
        const int status =                                                                         \
            before > fmi1Warning ? before : (int)calls.Get##Type(m->slave, r, n, values);          \
        return (fmi2Status)(status > before ? status : before);                                    \
    }
VALUES(Real)
VALUES(Integer)
VALUES(String)

SHOWN fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                const fmi2Boolean values[]) {
    Instance *m = c;
    int worst = fmi1OK;
    for (size_t i = 0; i < n && worst <= fmi1Warning; i++) {
        const fmi1Boolean value = values[i] != 0;
        const int status = (int)calls.SetBoolean(m->slave, r + i, 1, &value);
        worst = status > worst ? status : worst;
    }
    return (fmi2Status)worst;
}

SHOWN fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                fmi2Boolean values[]) {
    Instance *m = c;
    int worst = initialized(m);
    for (size_t i = 0; i < n && worst <= fmi1Warning; i++) {
        fmi1Boolean value = fmi1False;
        const int status = (int)calls.GetBoolean(m->slave, r + i, 1, &value);
        values[i] = value != 0;
        worst = status > worst ? status : worst;
    }
    return (fmi2Status)worst;
}
