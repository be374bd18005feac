/* FMI 1.0 under the names of FMI 2.0; built once for each FMU, whose functions the importer puts
 * into `calls`.
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

/* The importer reads these names, and what each is needed for: (C)o-simulation, (M)odel exchange.
 */
#define FMI1_CALLS(X)                                                                              \
    X(InstantiateSlave, "C")                                                                       \
    X(InitializeSlave, "C")                                                                        \
    X(TerminateSlave, "C")                                                                         \
    X(ResetSlave, "C")                                                                             \
    X(FreeSlaveInstance, "C")                                                                      \
    X(DoStep, "C")                                                                                 \
    X(SetRealInputDerivatives, "C")                                                                \
    X(InstantiateModel, "M")                                                                       \
    X(Initialize, "M")                                                                             \
    X(Terminate, "M")                                                                              \
    X(FreeModelInstance, "M")                                                                      \
    X(SetTime, "M")                                                                                \
    X(SetContinuousStates, "M")                                                                    \
    X(GetContinuousStates, "M")                                                                    \
    X(GetNominalContinuousStates, "M")                                                             \
    X(GetDerivatives, "M")                                                                         \
    X(GetEventIndicators, "M")                                                                     \
    X(CompletedIntegratorStep, "M")                                                                \
    X(EventUpdate, "M")                                                                            \
    X(SetReal, "CM")                                                                               \
    X(SetInteger, "CM")                                                                            \
    X(SetBoolean, "CM")                                                                            \
    X(SetString, "CM")                                                                             \
    X(GetReal, "CM")                                                                               \
    X(GetInteger, "CM")                                                                            \
    X(GetBoolean, "CM")                                                                            \
    X(GetString, "CM")

#define FIELD(name, interfaces) fmi1##name##TYPE *name;
SHOWN struct {
    FMI1_CALLS(FIELD)
} calls;

typedef struct {
    fmi1Component own;
    bool exchange;
    double start, stop; /* s */
    fmi1Boolean controlled;
    double tolerance; /* relative, where controlled */
    bool initialized;
    fmi1EventInfo info; /* of the last update of discrete states */
    bool updated;       /* by Initialize, and not yet asked for */
} Instance;

static int initialized(Instance *m) {
    if (m->initialized)
        return fmi1OK;
    m->initialized = true;
    if (!m->exchange)
        return (int)calls.InitializeSlave(m->own, m->start, fmi1True, m->stop);
    m->updated = true;
    const int status = (int)calls.SetTime(m->own, m->start);
    return status > fmi1Warning
               ? status
               : (int)calls.Initialize(m->own, m->controlled, m->tolerance, &m->info);
}

SHOWN fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                    fmi2String location, const fmi2CallbackFunctions *given,
                                    fmi2Boolean visible, fmi2Boolean logging) {
    /* The first argument of this logger is the instance and not an environment; the rest agrees. */
    const fmi1CallbackFunctions callbacks = {(fmi1CallbackLogger)(void (*)(void))given->logger,
                                             calloc, free, NULL};
    Instance *m = calloc(1, sizeof *m);
    if (m) {
        m->exchange = type == fmi2ModelExchange;
        m->own = m->exchange ? calls.InstantiateModel(name, guid, callbacks, (fmi1Boolean)logging)
                             : calls.InstantiateSlave(name, guid, location,
                                                      "application/x-fmu-sharedlibrary", 0.0,
                                                      (fmi1Boolean)visible, fmi1False, callbacks,
                                                      (fmi1Boolean)logging);
    }
    if (m && !m->own) {
        free(m);
        m = NULL;
    }
    return m;
}

SHOWN void fmi2FreeInstance(fmi2Component c) {
    Instance *m = c;
    (m->exchange ? calls.FreeModelInstance : calls.FreeSlaveInstance)(m->own);
    free(m);
}

/* Model Exchange has none: each run has a new instance. */
SHOWN fmi2Status fmi2Reset(fmi2Component c) {
    Instance *m = c;
    m->initialized = false;
    return (fmi2Status)calls.ResetSlave(m->own);
}

SHOWN fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                     fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    Instance *m = c;
    (void)has_stop;
    m->controlled = has_tolerance != 0;
    m->tolerance = tolerance;
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
    Instance *m = c;
    return (fmi2Status)(m->exchange ? calls.Terminate : calls.TerminateSlave)(m->own);
}

SHOWN fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final) {
    (void) final;
    return (fmi2Status)calls.DoStep(((Instance *)c)->own, t, h, fmi1True);
}

SHOWN fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[],
                                             size_t n, const fmi2Integer orders[],
                                             const fmi2Real values[]) {
    return (fmi2Status)calls.SetRealInputDerivatives(((Instance *)c)->own, r, n, orders, values);
}

/* FMI 1.0 does not tell whether a slave has terminated. */
SHOWN fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

#define VALUES(Type)                                                                               \
    SHOWN fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference r[], size_t n,        \
                                   const fmi2##Type values[]) {                                    \
        return (fmi2Status)calls.Set##Type(((Instance *)c)->own, r, n, values);                    \
    }                                                                                              \
    SHOWN fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference r[], size_t n,        \
                                   fmi2##Type values[]) {                                          \
        Instance *m = c;                                                                           \
        const int before = initialized(m);                                                         \
        const int status =                                                                         \
            before > fmi1Warning ? before : (int)calls.Get##Type(m->own, r, n, values);            \
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
        const int status = (int)calls.SetBoolean(m->own, r + i, 1, &value);
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
        const int status = (int)calls.GetBoolean(m->own, r + i, 1, &value);
        values[i] = value != 0;
        worst = status > worst ? status : worst;
    }
    return (fmi2Status)worst;
}

/* FMI 1.0 has no modes. */
SHOWN fmi2Status fmi2EnterEventMode(fmi2Component c) { return (void)c, fmi2OK; }
SHOWN fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return (void)c, fmi2OK; }

SHOWN fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    Instance *m = c;
    const int status = m->updated ? fmi1OK : (int)calls.EventUpdate(m->own, fmi1False, &m->info);
    /* Initialize has made all updates. */
    info->newDiscreteStatesNeeded = !m->updated && !m->info.iterationConverged;
    info->terminateSimulation = m->info.terminateSimulation != 0;
    info->nominalsOfContinuousStatesChanged = m->info.stateValueReferencesChanged != 0;
    info->valuesOfContinuousStatesChanged = m->info.stateValuesChanged != 0;
    info->nextEventTimeDefined = m->info.upcomingTimeEvent != 0;
    info->nextEventTime = m->info.nextEventTime;
    m->updated = false;
    return (fmi2Status)status;
}

SHOWN fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_rollback,
                                             fmi2Boolean *event, fmi2Boolean *terminate) {
    fmi1Boolean update = fmi1False;
    (void)no_rollback;
    const int status = (int)calls.CompletedIntegratorStep(((Instance *)c)->own, &update);
    *event = update != 0;
    *terminate = fmi2False;
    return (fmi2Status)status;
}

SHOWN fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) {
    return (fmi2Status)calls.SetTime(((Instance *)c)->own, t);
}

#define VECTOR(name, old, constant)                                                                \
    SHOWN fmi2Status fmi2##name(fmi2Component c, constant fmi2Real values[], size_t n) {           \
        return (fmi2Status)calls.old(((Instance *)c)->own, values, n);                             \
    }
VECTOR(SetContinuousStates, SetContinuousStates, const)
VECTOR(GetContinuousStates, GetContinuousStates, )
VECTOR(GetNominalsOfContinuousStates, GetNominalContinuousStates, )
VECTOR(GetDerivatives, GetDerivatives, )
VECTOR(GetEventIndicators, GetEventIndicators, )
