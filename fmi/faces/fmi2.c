/* FMI 2.0, what both interfaces share, and Co-Simulation: names and types over face.h. */
#include "fmi2.h"

static void emit(const Logger *logger, const char *name, Status status, const char *category,
                 const char *message) {
    ((fmi2CallbackLogger)logger->callback)(logger->environment, name, (fmi2Status)status, category,
                                           "%s", message);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[]) {
    REQUIRE(ANY);
    NEED(!nCategories || categories);
    return (fmi2Status)instance_log(c, loggingOn, nCategories, categories);
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean loggingOn) {
    Logger logger = {emit, NULL, NULL, loggingOn};
    if (fmuType != fmi2ModelExchange && fmuType != fmi2CoSimulation)
        return NULL;
    if (functions) {
        logger.callback = (void (*)(void))functions->logger;
        logger.environment = functions->componentEnvironment;
    }
    return instance_new(instanceName, fmuGUID, fmuResourceLocation, fmuType == fmi2ModelExchange,
                        logger);
}

void fmi2FreeInstance(fmi2Component c) { instance_free(c); }

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime) {
    REQUIRE(INSTANTIATED);
    return (fmi2Status)instance_set_up(c, startTime, stopTimeDefined, stopTime);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    REQUIRE(INSTANTIATED);
    return (fmi2Status)instance_enter_initialization(c);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    REQUIRE(INITIALIZATION);
    return (fmi2Status)instance_exit_initialization(c);
}

fmi2Status fmi2Terminate(fmi2Component c) {
    REQUIRE(STEPPING | EVENT | CONTINUOUS);
    return (fmi2Status)instance_terminate(c);
}

fmi2Status fmi2Reset(fmi2Component c) {
    REQUIRE(ANY);
    return (fmi2Status)instance_reset(c);
}

#define ACCESS(Name, fmi2Type_, TYPE)                                                              \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,           \
                             fmi2Type_ value[]) {                                                  \
        REQUIRE(ANY);                                                                              \
        NEED(!nvr || (vr && value));                                                               \
        for (size_t k = 0; k < nvr; k++) {                                                         \
            double value_k;                                                                        \
            if (instance_get(c, vr[k], TYPE, &value_k, __func__) != OK)                            \
                return fmi2Error;                                                                  \
            value[k] = (fmi2Type_)value_k;                                                         \
        }                                                                                          \
        return fmi2OK;                                                                             \
    }                                                                                              \
    fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,           \
                             const fmi2Type_ value[]) {                                            \
        REQUIRE(ALIVE);                                                                            \
        NEED(!nvr || (vr && value));                                                               \
        for (size_t k = 0; k < nvr; k++)                                                           \
            if (instance_accepts(c, vr[k], TYPE, (double)value[k], __func__) != OK)                \
                return fmi2Error;                                                                  \
        for (size_t k = 0; k < nvr; k++)                                                           \
            if (instance_put(c, vr[k], (double)value[k]) != OK)                                    \
                return fmi2Error;                                                                  \
        return fmi2OK;                                                                             \
    }

ACCESS(Real, fmi2Real, REAL)
ACCESS(Integer, fmi2Integer, INTEGER)
ACCESS(Boolean, fmi2Boolean, BOOLEAN)

/* There are no strings: only an empty request can be met. */
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[]) {
    REQUIRE(ANY);
    NEED(!nvr || (vr && value));
    return nvr ? (fmi2Status)instance_check(c, vr[0], STRING, __func__) : fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[]) {
    REQUIRE(ALIVE);
    NEED(!nvr || (vr && value));
    return nvr ? (fmi2Status)instance_check(c, vr[0], STRING, __func__) : fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    REQUIRE(ANY);
    NEED(FMUstate);
    return (fmi2Status)instance_save(c, FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate) {
    REQUIRE(ANY);
    return (fmi2Status)instance_restore(c, FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate) {
    REQUIRE(ANY);
    return FMUstate ? (fmi2Status)instance_forget(c, FMUstate) : fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size) {
    REQUIRE(ANY);
    NEED(size);
    return (fmi2Status)instance_serialized_size(c, FMUstate, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte state[],
                                 size_t size) {
    REQUIRE(ANY);
    NEED(state);
    return (fmi2Status)instance_serialize(c, FMUstate, (uint8_t *)state, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte state[], size_t size,
                                   fmi2FMUstate *FMUstate) {
    REQUIRE(ANY);
    NEED(state && FMUstate);
    return (fmi2Status)instance_deserialize(c, (const uint8_t *)state, size, FMUstate);
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint,
                      fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint) {
    REQUIRE(STEPPING);
    return (fmi2Status)instance_step(c, currentCommunicationPoint, communicationStepSize);
}

/* Every step is finished when fmi2DoStep returns. */
fmi2Status fmi2CancelStep(fmi2Component c) {
    REQUIRE(0);
    return fmi2Error;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value) {
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value) {
    REQUIRE(STEPPING | BROKEN | ENDED);
    NEED(value);
    if (s != fmi2LastSuccessfulTime)
        return fmi2Discard;
    *value = instance_time(c);
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value) {
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value) {
    REQUIRE(STEPPING | BROKEN | ENDED);
    NEED(value);
    if (s != fmi2Terminated)
        return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value) {
    return fmi2Discard;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                        size_t nUnknown, const fmi2ValueReference known[],
                                        size_t nKnown, const fmi2Real dvKnown[],
                                        fmi2Real dvUnknown[]) {
    REQUIRE(INITIALIZATION | STEPPING | EVENT | CONTINUOUS | ENDED);
    NEED((!nUnknown || (unknown && dvUnknown)) && (!nKnown || (known && dvKnown)));
    return (fmi2Status)slopes_multiply(c, DIRECTIONAL, (Chosen){unknown, nUnknown},
                                       (Chosen){known, nKnown}, dvKnown, dvUnknown, __func__);
}

/* Not declared in modelDescription.xml. */
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[]) {
    return (fmi2Status)instance_unavailable(c, __func__);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[]) {
    return (fmi2Status)instance_unavailable(c, __func__);
}
