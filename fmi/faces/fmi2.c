/* FMI 2.0 over face.h. */
#include <fmi2Functions.h>

#define FMI(name) fmi2##name
#define fmi2Instance fmi2Component
#define fmi2FMUState fmi2FMUstate
#define fmi2GetFMUState fmi2GetFMUstate
#define fmi2SetFMUState fmi2SetFMUstate
#define fmi2FreeFMUState fmi2FreeFMUstate
#define fmi2SerializedFMUStateSize fmi2SerializedFMUstateSize
#define fmi2SerializeFMUState fmi2SerializeFMUstate
#define fmi2DeserializeFMUState fmi2DeSerializeFMUstate
#define fmi2GetContinuousStateDerivatives fmi2GetDerivatives
#define COUNTED
#define REQUIRE_COUNTED
#include "both.h"

static void emit(const Logger *logger, const char *name, Status status, const char *category,
                 const char *message) {
    ((fmi2CallbackLogger)logger->callback)(logger->environment, name, (fmi2Status)status, category,
                                           "%s", message);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean loggingOn) {
    Logger logger = {emit, NULL, NULL, loggingOn};
    if (type != fmi2ModelExchange && type != fmi2CoSimulation)
        return NULL;
    if (functions) {
        logger.callback = (void (*)(void))functions->logger;
        logger.environment = functions->componentEnvironment;
    }
    return instance_new(name, guid, resources, type == fmi2ModelExchange, logger);
}

fmi2Status fmi2SetupExperiment(fmi2Component instance, fmi2Boolean toleranceDefined,
                               fmi2Real tolerance, fmi2Real startTime, fmi2Boolean stopTimeDefined,
                               fmi2Real stopTime) {
    REQUIRE(INSTANTIATED);
    return (fmi2Status)instance_set_up(instance, startTime, stopTimeDefined, stopTime);
}

CHANGE(EnterInitializationMode, INSTANTIATED, instance_enter_initialization(instance))
CHANGE(CancelStep, 0, ERROR) /* every step is finished when fmi2DoStep returns */

ACCESS(Real, REAL)
ACCESS(Integer, INTEGER)
ACCESS(Boolean, BOOLEAN)

/* There are no strings: only an empty request can be met. */
#define STRINGS(name, phases, constant)                                                            \
    fmi2Status name(fmi2Component instance, const fmi2ValueReference references[], size_t count,   \
                    constant fmi2String values[]) {                                                \
        REQUIRE(phases);                                                                           \
        NEED(!count || (references && values));                                                    \
        return count ? (fmi2Status)instance_check(instance, references[0], STRING, __func__)       \
                     : fmi2OK;                                                                     \
    }
STRINGS(fmi2GetString, ANY, )
STRINGS(fmi2SetString, ALIVE, const)

fmi2Status fmi2DoStep(fmi2Component instance, fmi2Real time, fmi2Real h, fmi2Boolean no_restore) {
    REQUIRE(STEPPING);
    return (fmi2Status)instance_step(instance, time, h);
}

#define STATUS(Name, Type, known, status)                                                          \
    fmi2Status fmi2Get##Name(fmi2Component instance, const fmi2StatusKind kind, Type *value) {     \
        REQUIRE(STEPPING | BROKEN | ENDED);                                                        \
        NEED(value);                                                                               \
        if (kind != known)                                                                         \
            return fmi2Discard;                                                                    \
        *value = status;                                                                           \
        return fmi2OK;                                                                             \
    }
#define NO_STATUS(Name, Type)                                                                      \
    fmi2Status fmi2Get##Name(fmi2Component instance, const fmi2StatusKind kind, Type *value) {     \
        return fmi2Discard;                                                                        \
    }
STATUS(RealStatus, fmi2Real, fmi2LastSuccessfulTime, instance_time(instance))
STATUS(BooleanStatus, fmi2Boolean, fmi2Terminated, fmi2False)
NO_STATUS(Status, fmi2Status)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(StringStatus, fmi2String)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component instance, const fmi2ValueReference unknown[],
                                        size_t nUnknown, const fmi2ValueReference known[],
                                        size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
    REQUIRE(STEPPING | INITIALIZED);
    NEED((!nUnknown || (unknown && dvUnknown)) && (!nKnown || (known && dvKnown)));
    return (fmi2Status)slopes_multiply(instance, DIRECTIONAL, (Chosen){unknown, nUnknown},
                                       (Chosen){known, nKnown}, dvKnown, dvUnknown, __func__);
}

fmi2Status fmi2NewDiscreteStates(fmi2Component instance, fmi2EventInfo *info) {
    REQUIRE(EVENT);
    NEED(info);
    bool changed, defined;
    double next;
    if (exchange_update(instance, &changed, &defined, &next) != OK)
        return fmi2Error;
    *info = (fmi2EventInfo){.valuesOfContinuousStatesChanged = changed,
                            .nextEventTimeDefined = defined,
                            .nextEventTime = next};
    return fmi2OK;
}

/* Not declared in modelDescription.xml. */
#define UNAVAILABLE(name, constant)                                                                \
    fmi2Status name(fmi2Component instance, const fmi2ValueReference references[], size_t count,   \
                    const fmi2Integer orders[], constant fmi2Real values[]) {                      \
        return (fmi2Status)instance_unavailable(instance, __func__);                               \
    }
UNAVAILABLE(fmi2SetRealInputDerivatives, const)
UNAVAILABLE(fmi2GetRealOutputDerivatives, )
