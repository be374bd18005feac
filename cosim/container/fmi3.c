/* FMI 3.0 for Co-Simulation: names and types of the standard over container.h. faces.py adds what
 * is missing: it refuses. */
#include <fmi3Functions.h>

#include "container.h"

#define REQUIRE(phases)                                                                            \
    if (!instance || !container_may(instance, phases, __func__))                                   \
    return fmi3Error

static void tell(const Container *container, Status status, const char *message) {
    const Logger *logger = container_logger(container);
    ((fmi3LogMessageCallback)logger->callback)(logger->environment, (fmi3Status)status,
                                               "logStatusError", message);
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean event_mode, fmi3Boolean early_return,
                                         const fmi3ValueReference intermediate[],
                                         size_t n_intermediate, fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    const Logger logger = {tell, (void (*)(void))log, environment};
    (void)visible, (void)logging; /* errors only, and those always */
    (void)event_mode, (void)early_return, (void)intermediate, (void)n_intermediate, (void)update;
    return container_new(name, token, resources, logger);
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)log;
    return NULL;
}

fmi3Instance
fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources,
                                  fmi3Boolean visible, fmi3Boolean logging,
                                  fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                  fmi3ClockUpdateCallback update, fmi3LockPreemptionCallback lock,
                                  fmi3UnlockPreemptionCallback unlock) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)log, (void)update, (void)lock, (void)unlock;
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) { container_free(instance); }

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n,
                               const fmi3String categories[]) {
    (void)on, (void)n, (void)categories;
    REQUIRE(ANY);
    return fmi3OK;
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean tolerance_defined,
                                       fmi3Float64 tolerance, fmi3Float64 start,
                                       fmi3Boolean stop_defined, fmi3Float64 stop) {
    (void)tolerance_defined, (void)tolerance;
    REQUIRE(NEW);
    const Status planned = container_plan(instance, start, stop_defined, stop);
    return (fmi3Status)(planned == OK ? container_enter_initialization(instance) : planned);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance) {
    REQUIRE(INITIALIZING);
    return (fmi3Status)container_leave_initialization(instance);
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance) {
    REQUIRE(STEPPING);
    return fmi3OK;
}

fmi3Status fmi3Terminate(fmi3Instance instance) {
    REQUIRE(STEPPING);
    return (fmi3Status)container_terminate(instance);
}

fmi3Status fmi3Reset(fmi3Instance instance) {
    REQUIRE(ANY);
    return (fmi3Status)container_reset(instance);
}

#define ACCESS(Name, TYPE)                                                                         \
    fmi3Status fmi3Get##Name(fmi3Instance instance, const fmi3ValueReference r[], size_t n,        \
                             fmi3##Name values[], size_t n_values) {                               \
        REQUIRE(ANY);                                                                              \
        for (size_t k = 0; k < n; k++) {                                                           \
            double value = 0.0;                                                                    \
            if (n != n_values || container_get(instance, r[k], TYPE, &value) != OK)                \
                return fmi3Error;                                                                  \
            values[k] = (fmi3##Name)value;                                                         \
        }                                                                                          \
        return fmi3OK;                                                                             \
    }                                                                                              \
    fmi3Status fmi3Set##Name(fmi3Instance instance, const fmi3ValueReference r[], size_t n,        \
                             const fmi3##Name values[], size_t n_values) {                         \
        REQUIRE(ALIVE);                                                                            \
        for (size_t k = 0; k < n; k++)                                                             \
            if (n != n_values || container_set(instance, r[k], TYPE, (double)values[k]) != OK)     \
                return fmi3Error;                                                                  \
        return fmi3OK;                                                                             \
    }

ACCESS(Float64, REAL)
ACCESS(Int32, INTEGER)
ACCESS(Boolean, BOOLEAN)

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_way_back,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *reached) {
    (void)no_way_back;
    REQUIRE(STEPPING);
    const Status status = container_step(instance, t, h);
    *event = *terminate = *early = false;
    *reached = container_time(instance);
    return (fmi3Status)status;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state) {
    REQUIRE(ALIVE);
    return (fmi3Status)container_save(instance, state);
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state) {
    REQUIRE(ALIVE);
    return (fmi3Status)container_restore(instance, state);
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state) {
    REQUIRE(ANY);
    return (fmi3Status)container_forget(instance, state);
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size) {
    REQUIRE(ALIVE);
    return (fmi3Status)container_size(instance, state, size);
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[],
                                 size_t size) {
    REQUIRE(ALIVE);
    return (fmi3Status)container_pack(instance, state, bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size,
                                   fmi3FMUState *state) {
    REQUIRE(ALIVE);
    return (fmi3Status)container_unpack(instance, bytes, size, state);
}
