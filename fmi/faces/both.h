/* The functions that FMI 2.0 and FMI 3.0 have in common. fmi2.c and fmi3.c each include this once,
 * with FMI(name), which adds the prefix, and the types below under the names of both. COUNTED is a
 * further parameter of getters and setters, REQUIRE_COUNTED its check. */
#include "face.h"

typedef FMI(Status) FmiStatus;
typedef FMI(Instance) FmiInstance;
typedef FMI(FMUState) FmiState;
typedef FMI(ValueReference) FmiReference;

/* Leave the calling function unless the instance exists and is in one of these phases. */
#define REQUIRE(phases)                                                                            \
    do {                                                                                           \
        if (!instance || instance_require(instance, phases, __func__) != OK)                       \
            return FMI(Error);                                                                     \
    } while (0)

/* Leave it unless the tool gave what must not be NULL. */
#define NEED(given)                                                                                \
    do {                                                                                           \
        if (!(given))                                                                              \
            return (FmiStatus)instance_lacks(instance, __func__);                                  \
    } while (0)

/* Leave it unless as many values came as there are scalar variables. */
#define REQUIRE_COUNT(references, values)                                                          \
    do {                                                                                           \
        if ((values) != (references))                                                              \
            return (FmiStatus)instance_mismatch(instance, references, values, __func__);           \
    } while (0)

#define INITIALIZED (INITIALIZATION | EVENT | CONTINUOUS | ENDED)

/* A function that only changes the phase. */
#define CHANGE(Name, phases, change)                                                               \
    FmiStatus FMI(Name)(FmiInstance instance) {                                                    \
        REQUIRE(phases);                                                                           \
        return (FmiStatus)change;                                                                  \
    }

CHANGE(ExitInitializationMode, INITIALIZATION, instance_exit_initialization(instance))
CHANGE(Terminate, STEPPING | EVENT | CONTINUOUS, instance_terminate(instance))
CHANGE(Reset, ANY, instance_reset(instance))
CHANGE(EnterEventMode, CONTINUOUS, exchange_enter(instance, EVENT))
CHANGE(EnterContinuousTimeMode, EVENT, exchange_enter(instance, CONTINUOUS))

const char *FMI(GetVersion)(void) { return FMI(Version); }

void FMI(FreeInstance)(FmiInstance instance) { instance_free(instance); }

FmiStatus FMI(SetDebugLogging)(FmiInstance instance, FMI(Boolean) on, size_t count,
                               const FMI(String) categories[]) {
    REQUIRE(ANY);
    NEED(!count || categories);
    return (FmiStatus)instance_log(instance, on, count, categories);
}

#define ACCESS(Name, TYPE)                                                                         \
    FmiStatus FMI(Get##Name)(FmiInstance instance, const FmiReference references[], size_t count,  \
                             FMI(Name) values[] COUNTED) {                                         \
        REQUIRE(ANY);                                                                              \
        REQUIRE_COUNTED;                                                                           \
        NEED(!count || (references && values));                                                    \
        for (size_t k = 0; k < count; k++) {                                                       \
            double value;                                                                          \
            if (instance_get(instance, references[k], TYPE, &value, __func__) != OK)               \
                return FMI(Error);                                                                 \
            values[k] = (FMI(Name))value;                                                          \
        }                                                                                          \
        return FMI(OK);                                                                            \
    }                                                                                              \
    FmiStatus FMI(Set##Name)(FmiInstance instance, const FmiReference references[], size_t count,  \
                             const FMI(Name) values[] COUNTED) {                                   \
        REQUIRE(ALIVE);                                                                            \
        REQUIRE_COUNTED;                                                                           \
        NEED(!count || (references && values));                                                    \
        for (size_t k = 0; k < count; k++)                                                         \
            if (instance_accepts(instance, references[k], TYPE, (double)values[k], __func__) !=    \
                OK)                                                                                \
                return FMI(Error);                                                                 \
        for (size_t k = 0; k < count; k++)                                                         \
            if (instance_put(instance, references[k], (double)values[k]) != OK)                    \
                return FMI(Error);                                                                 \
        return FMI(OK);                                                                            \
    }

FmiStatus FMI(GetFMUState)(FmiInstance instance, FmiState *state) {
    REQUIRE(ANY);
    NEED(state);
    return (FmiStatus)instance_save(instance, state);
}

FmiStatus FMI(SetFMUState)(FmiInstance instance, FmiState state) {
    REQUIRE(ANY);
    return (FmiStatus)instance_restore(instance, state);
}

FmiStatus FMI(FreeFMUState)(FmiInstance instance, FmiState *state) {
    REQUIRE(ANY);
    return state ? (FmiStatus)instance_forget(instance, state) : FMI(OK);
}

FmiStatus FMI(SerializedFMUStateSize)(FmiInstance instance, FmiState state, size_t *size) {
    REQUIRE(ANY);
    NEED(size);
    return (FmiStatus)instance_serialized_size(instance, state, size);
}

FmiStatus FMI(SerializeFMUState)(FmiInstance instance, FmiState state, FMI(Byte) bytes[],
                                 size_t size) {
    REQUIRE(ANY);
    NEED(bytes);
    return (FmiStatus)instance_serialize(instance, state, (uint8_t *)bytes, size);
}

FmiStatus FMI(DeserializeFMUState)(FmiInstance instance, const FMI(Byte) bytes[], size_t size,
                                   FmiState *state) {
    REQUIRE(ANY);
    NEED(bytes && state);
    return (FmiStatus)instance_deserialize(instance, (const uint8_t *)bytes, size, state);
}

/* Nothing depends on where the solver's steps end. */
FmiStatus FMI(CompletedIntegratorStep)(FmiInstance instance, FMI(Boolean) no_restore,
                                       FMI(Boolean) * enter_event_mode, FMI(Boolean) * terminate) {
    REQUIRE(CONTINUOUS);
    NEED(enter_event_mode && terminate);
    *enter_event_mode = *terminate = 0;
    return FMI(OK);
}

FmiStatus FMI(SetTime)(FmiInstance instance, double time) {
    REQUIRE(EVENT | CONTINUOUS);
    return (FmiStatus)exchange_set_time(instance, time);
}

#define EXCHANGE(Name, phases, call, constant)                                                     \
    FmiStatus FMI(Name)(FmiInstance instance, constant double values[], size_t count) {            \
        REQUIRE(phases);                                                                           \
        NEED(!count || values);                                                                    \
        return (FmiStatus)call(instance, values, count);                                           \
    }

EXCHANGE(SetContinuousStates, CONTINUOUS, exchange_set_states, const)
EXCHANGE(GetContinuousStates, INITIALIZED, exchange_get_states, )
EXCHANGE(GetContinuousStateDerivatives, INITIALIZED, exchange_get_derivatives, )
EXCHANGE(GetNominalsOfContinuousStates, INSTANTIATED | INITIALIZED, exchange_get_nominals, )
EXCHANGE(GetEventIndicators, INITIALIZED, exchange_get_indicators, )
