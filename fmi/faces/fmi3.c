/* FMI 3.0, what both interfaces share, and Co-Simulation: names and types over face.h. */
#include "fmi3.h"

static void emit(const Logger *logger, const char *name, Status status, const char *category,
                 const char *message) {
    ((fmi3LogMessageCallback)logger->callback)(logger->environment, (fmi3Status)status, category,
                                               message);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[]) {
    REQUIRE(ANY);
    NEED(!nCategories || categories);
    return (fmi3Status)instance_log(instance, loggingOn, nCategories, categories);
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
    fmi3Boolean earlyReturnAllowed, const fmi3ValueReference requiredIntermediateVariables[],
    size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate) {
    const Logger logger = {emit, (void (*)(void))logMessage, instanceEnvironment, loggingOn};
    return instance_new(instanceName, instantiationToken, resourcePath, false, logger);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible,
                                          fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage) {
    const Logger logger = {emit, (void (*)(void))logMessage, instanceEnvironment, loggingOn};
    return instance_new(instanceName, instantiationToken, resourcePath, true, logger);
}

void fmi3FreeInstance(fmi3Instance instance) { instance_free(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    REQUIRE(INSTANTIATED);
    if (instance_set_up(instance, startTime, stopTimeDefined, stopTime) != OK)
        return fmi3Error;
    return (fmi3Status)instance_enter_initialization(instance);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    REQUIRE(INITIALIZATION);
    return (fmi3Status)instance_exit_initialization(instance);
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    REQUIRE(STEPPING | EVENT | CONTINUOUS);
    return (fmi3Status)instance_terminate(instance);
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    REQUIRE(ANY);
    return (fmi3Status)instance_reset(instance);
}

#define ACCESS(Name, TYPE)                                                                         \
    fmi3Status fmi3Get##Name(fmi3Instance instance, const fmi3ValueReference references[],         \
                             size_t count, fmi3##Name values[], size_t nValues) {                  \
        REQUIRE(ANY);                                                                              \
        REQUIRE_COUNT(count, nValues);                                                             \
        NEED(!count || (references && values));                                                    \
        for (size_t k = 0; k < count; k++) {                                                       \
            double value_k;                                                                        \
            if (instance_get(instance, references[k], TYPE, &value_k, __func__) != OK)             \
                return fmi3Error;                                                                  \
            values[k] = (fmi3##Name)value_k;                                                       \
        }                                                                                          \
        return fmi3OK;                                                                             \
    }                                                                                              \
    fmi3Status fmi3Set##Name(fmi3Instance instance, const fmi3ValueReference references[],         \
                             size_t count, const fmi3##Name values[], size_t nValues) {            \
        REQUIRE(ALIVE);                                                                            \
        REQUIRE_COUNT(count, nValues);                                                             \
        NEED(!count || (references && values));                                                    \
        for (size_t k = 0; k < count; k++)                                                         \
            if (instance_accepts(instance, references[k], TYPE, (double)values[k], __func__) !=    \
                OK)                                                                                \
                return fmi3Error;                                                                  \
        for (size_t k = 0; k < count; k++)                                                         \
            if (instance_put(instance, references[k], (double)values[k]) != OK)                    \
                return fmi3Error;                                                                  \
        return fmi3OK;                                                                             \
    }

ACCESS(Float64, REAL)
ACCESS(Int32, INTEGER)
ACCESS(Boolean, BOOLEAN)

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                        size_t nUnknowns, const fmi3ValueReference knowns[],
                                        size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                        fmi3Float64 sensitivity[], size_t nSensitivity) {
    REQUIRE(INITIALIZATION | STEPPING | EVENT | CONTINUOUS | ENDED);
    REQUIRE_COUNT(nKnowns, nSeed);
    REQUIRE_COUNT(nUnknowns, nSensitivity);
    NEED((!nUnknowns || (unknowns && sensitivity)) && (!nKnowns || (knowns && seed)));
    return (fmi3Status)slopes_multiply(instance, DIRECTIONAL, (Chosen){unknowns, nUnknowns},
                                       (Chosen){knowns, nKnowns}, seed, sensitivity, __func__);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                    size_t nUnknowns, const fmi3ValueReference knowns[],
                                    size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                    fmi3Float64 sensitivity[], size_t nSensitivity) {
    REQUIRE(INITIALIZATION | STEPPING | EVENT | CONTINUOUS | ENDED);
    REQUIRE_COUNT(nUnknowns, nSeed);
    REQUIRE_COUNT(nKnowns, nSensitivity);
    NEED((!nUnknowns || (unknowns && seed)) && (!nKnowns || (knowns && sensitivity)));
    return (fmi3Status)slopes_multiply(instance, ADJOINT, (Chosen){unknowns, nUnknowns},
                                       (Chosen){knowns, nKnowns}, seed, sensitivity, __func__);
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    REQUIRE(ANY);
    NEED(FMUState);
    return (fmi3Status)instance_save(instance, FMUState);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState) {
    REQUIRE(ANY);
    return (fmi3Status)instance_restore(instance, FMUState);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState) {
    REQUIRE(ANY);
    return FMUState ? (fmi3Status)instance_forget(instance, FMUState) : fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size) {
    REQUIRE(ANY);
    NEED(size);
    return (fmi3Status)instance_serialized_size(instance, FMUState, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState, fmi3Byte state[],
                                 size_t size) {
    REQUIRE(ANY);
    NEED(state);
    return (fmi3Status)instance_serialize(instance, FMUState, state, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte state[], size_t size,
                                   fmi3FMUState *FMUState) {
    REQUIRE(ANY);
    NEED(state && FMUState);
    return (fmi3Status)instance_deserialize(instance, state, size, FMUState);
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    REQUIRE(STEPPING);
    return fmi3OK;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime) {
    REQUIRE(STEPPING);
    NEED(eventHandlingNeeded && terminateSimulation && earlyReturn && lastSuccessfulTime);
    const Status status = instance_step(instance, currentCommunicationPoint, communicationStepSize);
    *eventHandlingNeeded = false;
    *terminateSimulation = false;
    *earlyReturn = false;
    *lastSuccessfulTime = instance_time(instance);
    return (fmi3Status)status;
}
