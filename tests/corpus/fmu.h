/* FMI 2.0 and FMI 3.0 for Co-Simulation over one Model. Include it after the definition of
 *
 *     Model
 *     static void start(Model *)                           start values
 *     static int set(Model *, const unsigned references[], size_t n, const double values[])
 *     static int get(Model *, const unsigned references[], size_t n, double values[])
 *
 * and of what the FMU does in each call, as macros that give a status. Define EXCHANGE, SAVES or
 * OWN_REALS for Model Exchange, for saved states, or to leave access to reals to the model. */
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-variable"

#ifndef STEP /* m, t, h; of FMI 3.0 also bool event, terminate, early and double reached */
#define STEP step(m, h)
#endif
#ifndef SETUP /* told, tolerance, t */
#define SETUP 0
#endif
#ifndef ENTER
#define ENTER 0
#endif
#ifndef LEAVE
#define LEAVE 0
#endif
#ifndef TERMINATE
#define TERMINATE 0
#endif
#ifndef RESET
#define RESET (start(m), 0)
#endif
#ifndef FREE
#define FREE free(m)
#endif
#ifndef MAKE /* token, resources, exchange, events, early, callbacks, log, environment */
#define MAKE make()
static Model *make(void) {
    Model *m = calloc(1, sizeof *m);
    if (m)
        start(m);
    return m;
}
#endif

#ifndef CALLED /* m; a status other than OK and Warning ends a call for states or of a solver */
#define CALLED(name) 0
#endif
#define DO(Status, name, ...)                                                                      \
    const int called = CALLED(name);                                                               \
    if (called == 0 || called == 1)                                                                \
        (void)(__VA_ARGS__);                                                                       \
    return (Status)called

/* A function of one shape in both versions. */
#define BOTH(name, parameters, ...)                                                                \
    fmi2Status fmi2##name parameters { return (fmi2Status)(__VA_ARGS__); }                         \
    fmi3Status fmi3##name parameters { return (fmi3Status)(__VA_ARGS__); }

#ifndef VERSION
#define VERSION(number) number
#define PLATFORM fmi2TypesPlatform
#endif
const char *fmi2GetTypesPlatform(void) { return PLATFORM; }
const char *fmi2GetVersion(void) { return VERSION("2.0"); }
const char *fmi3GetVersion(void) { return VERSION("3.0"); }
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token,
                              fmi2String resources, const fmi2CallbackFunctions *callbacks,
                              fmi2Boolean visible, fmi2Boolean logging) {
    const bool exchange = type == fmi2ModelExchange, events = false, early = false;
    const fmi3LogMessageCallback log = NULL;
    void *environment = NULL;
    return MAKE;
}
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    const bool exchange = false;
    const fmi2CallbackFunctions *callbacks = NULL;
    return MAKE;
}
void fmi2FreeInstance(fmi2Component m) { FREE; }
void fmi3FreeInstance(fmi3Instance m) { FREE; }
#ifndef LISTEN /* on */
#define LISTEN 0
#endif
fmi2Status fmi2SetDebugLogging(fmi2Component m, fmi2Boolean on, size_t n, const fmi2String s[]) {
    return (fmi2Status)(LISTEN);
}
fmi3Status fmi3SetDebugLogging(fmi3Instance m, fmi3Boolean on, size_t n, const fmi3String s[]) {
    return (fmi3Status)(LISTEN);
}
fmi2Status fmi2SetupExperiment(fmi2Component m, fmi2Boolean told, fmi2Real tolerance, fmi2Real t,
                               fmi2Boolean ends, fmi2Real stop) {
    return (fmi2Status)(SETUP);
}
fmi2Status fmi2EnterInitializationMode(fmi2Component m) { return (fmi2Status)(ENTER); }
fmi3Status fmi3EnterInitializationMode(fmi3Instance m, fmi3Boolean told, fmi3Float64 tolerance,
                                       fmi3Float64 t, fmi3Boolean ends, fmi3Float64 stop) {
    return SETUP ? fmi3Error : (fmi3Status)(ENTER);
}
BOTH(ExitInitializationMode, (void *m), LEAVE)
BOTH(Terminate, (void *m), TERMINATE)
#ifndef WITHOUT_RESET
BOTH(Reset, (void *m), RESET)
#endif
#ifndef OWN_REALS
fmi2Status fmi2SetReal(fmi2Component m, const unsigned r[], size_t n, const fmi2Real v[]) {
    return (fmi2Status)set(m, r, n, v);
}
fmi2Status fmi2GetReal(fmi2Component m, const unsigned r[], size_t n, fmi2Real v[]) {
    return (fmi2Status)get(m, r, n, v);
}
fmi3Status fmi3SetFloat64(fmi3Instance m, const unsigned r[], size_t n, const fmi3Float64 v[],
                          size_t values) {
    return (fmi3Status)set(m, r, n, v);
}
fmi3Status fmi3GetFloat64(fmi3Instance m, const unsigned r[], size_t n, fmi3Float64 v[],
                          size_t values) {
    return (fmi3Status)get(m, r, n, v);
}
#endif
fmi2Status fmi2DoStep(fmi2Component m, fmi2Real t, fmi2Real h, fmi2Boolean no_set) {
    bool answers[3] = {false}, *event = answers, *terminate = answers + 1, *early = answers + 2;
    double end = t + h, *reached = &end;
    const int status = STEP;
    return *terminate ? fmi2Discard : (fmi2Status)status;
}
fmi3Status fmi3DoStep(fmi3Instance m, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_set,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *reached) {
    *event = *terminate = *early = false;
    *reached = t + h;
    return (fmi3Status)(STEP);
}

#ifdef SAVES
#ifndef RESTORED /* after a state was restored */
#define RESTORED (void)0
#endif
#ifndef TAKE
#define TAKE(size) malloc(size)
#define GIVE(room) free(room)
#endif
#ifndef SAVE
#define SAVE memcpy(*s = *s ? *s : TAKE(sizeof(Model)), m, sizeof(Model))
#define RESTORE memcpy(m, s, sizeof(Model)), RESTORED
#define SIZE sizeof(Model)
#endif
#ifndef FORGET
#define FORGET GIVE(*s), *s = NULL
#endif
#ifndef WRITE
#define WRITE memcpy(room, s, size < sizeof(Model) ? size : sizeof(Model))
#define READ memcpy(*s = TAKE(sizeof(Model)), room, size < sizeof(Model) ? size : sizeof(Model))
#endif
#define SAVED(fmi, State, Deserialize, Byte)                                                       \
    fmi##Status fmi##Get##State(void *m, void **s) { DO(fmi##Status, "GetState", SAVE); }          \
    fmi##Status fmi##Set##State(void *m, void *s) { DO(fmi##Status, "SetState", RESTORE); }        \
    fmi##Status fmi##Free##State(void *m, void **s) {                                              \
        FORGET;                                                                                    \
        return (fmi##Status)CALLED("FreeState");                                                   \
    }                                                                                              \
    fmi##Status fmi##Serialized##State##Size(void *m, void *s, size_t *size) {                     \
        DO(fmi##Status, "SerializedSize", *size = SIZE);                                           \
    }                                                                                              \
    fmi##Status fmi##Serialize##State(void *m, void *s, Byte room[], size_t size) {                \
        DO(fmi##Status, "Serialize", WRITE);                                                       \
    }                                                                                              \
    fmi##Status fmi##Deserialize##State(void *m, const Byte room[], size_t size, void **s) {       \
        DO(fmi##Status, "Deserialize", READ);                                                      \
    }
SAVED(fmi2, FMUstate, DeSerialize, fmi2Byte)
SAVED(fmi3, FMUState, Deserialize, fmi3Byte)
#endif

#ifdef EXCHANGE /* over m->x and derivatives(m, dx) */
#ifndef N_STATES
#define N_STATES 0
#endif
#ifndef INDICATORS
#define INDICATORS 0
#define INDICATE 0
#endif
#ifndef UPDATE /* update may set the fields of info */
#define UPDATE 0
#endif
#ifndef AT /* where time and states are, and how they are set */
#define AT(m) ((Model *)m)->t
#define STATES_OF(m) ((Model *)m)->x
#define PUT memcpy(STATES_OF(m), x, n * sizeof *x)
#endif
#ifndef NOMINAL
#define NOMINAL 1.0
#endif
#ifndef ENTER_EVENT_MODE
#define ENTER_EVENT_MODE 0
#endif
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    const bool exchange = true, events = false, early = false;
    const fmi2CallbackFunctions *callbacks = NULL;
    return MAKE;
}
static int nominals(double x[], size_t n) {
    for (size_t i = 0; i < n; i++)
        x[i] = NOMINAL;
    return 0;
}
#define SOLVED(name, parameters, ...)                                                              \
    fmi2Status fmi2##name parameters { DO(fmi2Status, #name, __VA_ARGS__); }                       \
    fmi3Status fmi3##name parameters { DO(fmi3Status, #name, __VA_ARGS__); }
SOLVED(EnterEventMode, (void *m), ENTER_EVENT_MODE)
SOLVED(EnterContinuousTimeMode, (void *m), 0)
SOLVED(SetTime, (void *m, double t), AT(m) = t)
SOLVED(GetContinuousStates, (void *m, double x[], size_t n), memcpy(x, STATES_OF(m), n * sizeof *x))
SOLVED(SetContinuousStates, (void *m, const double x[], size_t n), PUT)
SOLVED(GetEventIndicators, (void *m, double z[], size_t n), INDICATE)
fmi2Status fmi2GetNominalsOfContinuousStates(void *m, double x[], size_t n) {
    DO(fmi2Status, "GetNominals", nominals(x, n));
}
fmi3Status fmi3GetNominalsOfContinuousStates(void *m, double x[], size_t n) {
    return (fmi3Status)fmi2GetNominalsOfContinuousStates(m, x, n);
}
fmi2Status fmi2GetDerivatives(void *m, double dx[], size_t n) {
    DO(fmi2Status, "GetDerivatives", derivatives(m, dx));
}
fmi3Status fmi3GetContinuousStateDerivatives(void *m, double dx[], size_t n) {
    return (fmi3Status)fmi2GetDerivatives(m, dx, n);
}
fmi3Status fmi3GetNumberOfContinuousStates(void *m, size_t *n) {
    DO(fmi3Status, "GetNumberOfContinuousStates", *n = N_STATES);
}
fmi3Status fmi3GetNumberOfEventIndicators(void *m, size_t *n) {
    DO(fmi3Status, "GetNumberOfEventIndicators", *n = INDICATORS);
}
fmi2Status fmi2CompletedIntegratorStep(void *m, fmi2Boolean no_set, fmi2Boolean *enter,
                                       fmi2Boolean *terminate) {
    DO(fmi2Status, "CompletedIntegratorStep", *enter = *terminate = fmi2False);
}
fmi3Status fmi3CompletedIntegratorStep(void *m, bool no_set, bool *enter, bool *terminate) {
    DO(fmi3Status, "CompletedIntegratorStep", *enter = *terminate = false);
}
fmi2Status fmi2NewDiscreteStates(void *m, fmi2EventInfo *info) {
    *info = (fmi2EventInfo){0};
    DO(fmi2Status, "UpdateDiscreteStates", UPDATE);
}
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance m, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominal, fmi3Boolean *states, fmi3Boolean *defined,
                                    fmi3Float64 *next) {
    fmi2EventInfo info;
    const fmi2Status status = fmi2NewDiscreteStates(m, &info);
    *again = info.newDiscreteStatesNeeded;
    *terminate = info.terminateSimulation;
    *nominal = info.nominalsOfContinuousStatesChanged;
    *states = info.valuesOfContinuousStatesChanged;
    *defined = info.nextEventTimeDefined;
    *next = info.nextEventTime;
    return (fmi3Status)status;
}
#endif
