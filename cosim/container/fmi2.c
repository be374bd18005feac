/* FMI 2.0 for Co-Simulation: names and types of the standard over container.h. faces.py adds what
 * is missing: it refuses. */
#include <fmi2Functions.h>

#include "container.h"

#define REQUIRE(phases)                                                                            \
    if (!c || !container_may(c, phases, __func__))                                                 \
    return fmi2Error

static void tell(const Container *container, Status status, const char *message) {
    const Logger *logger = container_logger(container);
    ((fmi2CallbackLogger)logger->callback)(logger->environment, container_name(container),
                                           (fmi2Status)status, "logStatusError", "%s", message);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token,
                              fmi2String resources, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean logging) {
    Logger logger = {tell, NULL, NULL};
    (void)visible, (void)logging; /* errors only, and those always */
    if (functions) {
        logger.callback = (void (*)(void))functions->logger;
        logger.environment = functions->componentEnvironment;
    }
    return type == fmi2CoSimulation ? container_new(name, token, resources, logger) : NULL;
}

void fmi2FreeInstance(fmi2Component c) { container_free(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n,
                               const fmi2String categories[]) {
    (void)on, (void)n, (void)categories;
    REQUIRE(ANY);
    return fmi2OK;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerance_defined, fmi2Real tolerance,
                               fmi2Real start, fmi2Boolean stop_defined, fmi2Real stop) {
    (void)tolerance_defined, (void)tolerance;
    REQUIRE(NEW);
    return (fmi2Status)container_plan(c, start, stop_defined, stop);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    REQUIRE(NEW);
    return (fmi2Status)container_enter_initialization(c);
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
    REQUIRE(INITIALIZING);
    return (fmi2Status)container_leave_initialization(c);
}

fmi2Status fmi2Terminate(fmi2Component c) {
    REQUIRE(STEPPING);
    return (fmi2Status)container_terminate(c);
}

fmi2Status fmi2Reset(fmi2Component c) {
    REQUIRE(ANY);
    return (fmi2Status)container_reset(c);
}

#define ACCESS(Name, TYPE)                                                                         \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference r[], size_t n,              \
                             fmi2##Name values[]) {                                                \
        REQUIRE(ANY);                                                                              \
        for (size_t k = 0; k < n; k++) {                                                           \
            double value = 0.0;                                                                    \
            if (container_get(c, r[k], TYPE, &value) != OK)                                        \
                return fmi2Error;                                                                  \
            values[k] = (fmi2##Name)value;                                                         \
        }                                                                                          \
        return fmi2OK;                                                                             \
    }                                                                                              \
    fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference r[], size_t n,              \
                             const fmi2##Name values[]) {                                          \
        REQUIRE(ALIVE);                                                                            \
        for (size_t k = 0; k < n; k++)                                                             \
            if (container_set(c, r[k], TYPE, (double)values[k]) != OK)                             \
                return fmi2Error;                                                                  \
        return fmi2OK;                                                                             \
    }

ACCESS(Real, REAL)
ACCESS(Integer, INTEGER)
ACCESS(Boolean, BOOLEAN)

/* There are no strings: only an empty request can be met. */
fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t n,
                         fmi2String values[]) {
    (void)r, (void)values;
    REQUIRE(ANY);
    return n ? (fmi2Status)container_refuse(c, __func__) : fmi2OK;
}

fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n,
                         const fmi2String values[]) {
    (void)r, (void)values;
    REQUIRE(ALIVE);
    return n ? (fmi2Status)container_refuse(c, __func__) : fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_way_back) {
    (void)no_way_back;
    REQUIRE(STEPPING);
    return (fmi2Status)container_step(c, t, h);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    REQUIRE(ALIVE);
    return (fmi2Status)container_save(c, state);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    REQUIRE(ALIVE);
    return (fmi2Status)container_restore(c, state);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    REQUIRE(ANY);
    return (fmi2Status)container_forget(c, state);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
    REQUIRE(ALIVE);
    return (fmi2Status)container_size(c, state, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[],
                                 size_t size) {
    REQUIRE(ALIVE);
    return (fmi2Status)container_pack(c, state, (uint8_t *)bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state) {
    REQUIRE(ALIVE);
    return (fmi2Status)container_unpack(c, (const uint8_t *)bytes, size, state);
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
    REQUIRE(ANY);
    if (kind != fmi2LastSuccessfulTime)
        return fmi2Discard;
    *value = container_time(c);
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
    REQUIRE(ANY);
    if (kind != fmi2Terminated)
        return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
    (void)c, (void)kind, (void)value;
    return fmi2Discard;
}
