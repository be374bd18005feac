/* FMI 3.0 over face.h. */
#include <fmi3Functions.h>

#define FMI(name) fmi3##name
#define COUNTED , size_t nValues
#define REQUIRE_COUNTED REQUIRE_COUNT(count, nValues)
#include "both.h"

static void emit(const Logger *logger, const char *name, Status status, const char *category,
                 const char *message) {
    ((fmi3LogMessageCallback)logger->callback)(logger->environment, (fmi3Status)status, category,
                                               message);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference intermediate[],
                                         size_t nIntermediate, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    const Logger logger = {emit, (void (*)(void))log, environment, loggingOn};
    return instance_new(name, token, resources, false, logger);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    const Logger logger = {emit, (void (*)(void))log, environment, loggingOn};
    return instance_new(name, token, resources, true, logger);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime) {
    REQUIRE(INSTANTIATED);
    if (instance_set_up(instance, startTime, stopTimeDefined, stopTime) != OK)
        return fmi3Error;
    return (fmi3Status)instance_enter_initialization(instance);
}

CHANGE(EnterStepMode, STEPPING, OK)

ACCESS(Float64, REAL)
ACCESS(Int32, INTEGER)
ACCESS(Boolean, BOOLEAN)

#define DERIVATIVE_PRODUCT(Name, PRODUCT, nGiven, nResults)                                        \
    fmi3Status fmi3Get##Name(fmi3Instance instance, const fmi3ValueReference unknowns[],           \
                             size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns,  \
                             const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[],    \
                             size_t nSensitivity) {                                                \
        REQUIRE(STEPPING | INITIALIZED);                                                           \
        REQUIRE_COUNT(nGiven, nSeed);                                                              \
        REQUIRE_COUNT(nResults, nSensitivity);                                                     \
        NEED((!nUnknowns || unknowns) && (!nKnowns || knowns));                                    \
        NEED((!nSeed || seed) && (!nSensitivity || sensitivity));                                  \
        return (fmi3Status)slopes_multiply(instance, PRODUCT, (Chosen){unknowns, nUnknowns},       \
                                           (Chosen){knowns, nKnowns}, seed, sensitivity,           \
                                           __func__);                                              \
    }
DERIVATIVE_PRODUCT(DirectionalDerivative, DIRECTIONAL, nKnowns, nUnknowns)
DERIVATIVE_PRODUCT(AdjointDerivative, ADJOINT, nUnknowns, nKnowns)

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 h,
                      fmi3Boolean no_restore, fmi3Boolean *event, fmi3Boolean *terminate,
                      fmi3Boolean *early, fmi3Float64 *last) {
    REQUIRE(STEPPING);
    NEED(event && terminate && early && last);
    const Status status = instance_step(instance, time, h);
    *event = *terminate = *early = false;
    *last = instance_time(instance);
    return (fmi3Status)status;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *again,
                                    fmi3Boolean *terminate, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *defined, fmi3Float64 *next) {
    REQUIRE(EVENT);
    NEED(again && terminate && nominals && values && defined && next);
    *again = *terminate = *nominals = false;
    return (fmi3Status)exchange_update(instance, values, defined, next);
}

#define NUMBER_OF(Name, number)                                                                    \
    fmi3Status fmi3GetNumberOf##Name(fmi3Instance instance, size_t *count) {                       \
        REQUIRE(ANY);                                                                              \
        NEED(count);                                                                               \
        *count = number;                                                                           \
        return fmi3OK;                                                                             \
    }
NUMBER_OF(EventIndicators, exchange_indicator_count(instance))
NUMBER_OF(ContinuousStates, exchange_count(instance))

/* The rest, which every binary must export: what modelDescription.xml does not declare. */
#define UNAVAILABLE(Name, ...)                                                                     \
    fmi3Status fmi3##Name(__VA_ARGS__) {                                                           \
        return (fmi3Status)instance_unavailable(instance, __func__);                               \
    }
#define OF fmi3Instance instance, const fmi3ValueReference references[], size_t count
#define UNAVAILABLE_TYPE(Name)                                                                     \
    UNAVAILABLE(Get##Name, OF, fmi3##Name values[], size_t nValues)                                \
    UNAVAILABLE(Set##Name, OF, const fmi3##Name values[], size_t nValues)

UNAVAILABLE_TYPE(Float32)
UNAVAILABLE_TYPE(Int8)
UNAVAILABLE_TYPE(UInt8)
UNAVAILABLE_TYPE(Int16)
UNAVAILABLE_TYPE(UInt16)
UNAVAILABLE_TYPE(UInt32)
UNAVAILABLE_TYPE(Int64)
UNAVAILABLE_TYPE(UInt64)
UNAVAILABLE_TYPE(String)
UNAVAILABLE(GetBinary, OF, size_t sizes[], fmi3Binary values[], size_t nValues)
UNAVAILABLE(SetBinary, OF, const size_t sizes[], const fmi3Binary values[], size_t nValues)
UNAVAILABLE(GetClock, OF, fmi3Clock values[])
UNAVAILABLE(SetClock, OF, const fmi3Clock values[])
UNAVAILABLE(GetIntervalDecimal, OF, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
UNAVAILABLE(GetIntervalFraction, OF, fmi3UInt64 counters[], fmi3UInt64 resolutions[],
            fmi3IntervalQualifier qualifiers[])
UNAVAILABLE(SetIntervalDecimal, OF, const fmi3Float64 intervals[])
UNAVAILABLE(SetIntervalFraction, OF, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
UNAVAILABLE(GetShiftDecimal, OF, fmi3Float64 shifts[])
UNAVAILABLE(GetShiftFraction, OF, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
UNAVAILABLE(SetShiftDecimal, OF, const fmi3Float64 shifts[])
UNAVAILABLE(SetShiftFraction, OF, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
UNAVAILABLE(GetOutputDerivatives, OF, const fmi3Int32 orders[], fmi3Float64 values[],
            size_t nValues)
UNAVAILABLE(GetNumberOfVariableDependencies, fmi3Instance instance, fmi3ValueReference reference,
            size_t *count)
UNAVAILABLE(GetVariableDependencies, fmi3Instance instance, fmi3ValueReference dependent,
            size_t elementsOfDependent[], fmi3ValueReference independents[],
            size_t elementsOfIndependents[], fmi3DependencyKind kinds[], size_t count)
UNAVAILABLE(EnterConfigurationMode, fmi3Instance instance)
UNAVAILABLE(ExitConfigurationMode, fmi3Instance instance)
UNAVAILABLE(EvaluateDiscreteStates, fmi3Instance instance)
UNAVAILABLE(ActivateModelPartition, fmi3Instance instance, fmi3ValueReference clock,
            fmi3Float64 time)

fmi3Instance
fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                  fmi3Boolean visible, fmi3Boolean loggingOn,
                                  fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                  fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                  fmi3UnlockPreemptionCallback unlock) {
    return NULL;
}
