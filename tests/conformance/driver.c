/* Takes one FMU, linked in, through its whole life: for the sanitizers to watch.
 *
 * Compiled with -DFMI=2 or -DFMI=3 together with the FMU's sources. The table of variables, which
 * the exporter generates, tells it what there is to set, so it fits every model.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "instance.h"

#if FMI == 2
#include <fmi2Functions.h>
typedef fmi2Component Slave;
typedef fmi2FMUstate State;
typedef fmi2Byte Byte;
#define CALL(name2, name3, ...) fmi2##name2(__VA_ARGS__)
#define SET(name2, name3, slave, reference, value) fmi2Set##name2(slave, reference, 1, value)
#define GET(name2, name3, slave, reference, value) fmi2Get##name2(slave, reference, 1, value)
typedef fmi2Boolean Boolean;
#else
#include <fmi3Functions.h>
typedef fmi3Instance Slave;
typedef fmi3FMUState State;
typedef fmi3Byte Byte;
#define CALL(name2, name3, ...) fmi3##name3(__VA_ARGS__)
#define SET(name2, name3, slave, reference, value) fmi3Set##name3(slave, reference, 1, value, 1)
#define GET(name2, name3, slave, reference, value) fmi3Get##name3(slave, reference, 1, value, 1)
typedef fmi3Boolean Boolean;
#endif

static int messages = 0;

static void require(int status, int expected, const char *what, unsigned variable) {
    if (status == expected)
        return;
    fprintf(stderr, "%s of variable %u gave status %d, expected %d\n", what, variable, status,
            expected);
    exit(1);
}

#define HAS_MODEL_EXCHANGE (IS_CONTINUOUS || IS_SAMPLED)

#if FMI == 2
static void hear(void *environment, const char *name, fmi2Status status, const char *category,
                 const char *format, ...) {
    (void)environment, (void)name, (void)status, (void)category, (void)format;
    messages++;
}

static Slave instantiate(const char *token, int model_exchange) {
    static const fmi2CallbackFunctions functions = {hear, calloc, free, NULL, NULL};
    const fmi2Type type = model_exchange ? fmi2ModelExchange : fmi2CoSimulation;
    return fmi2Instantiate("driver", type, token, "", &functions, 0, 1);
}

static void initialize(Slave slave) {
    require(fmi2SetupExperiment(slave, 0, 0.0, 0.0, 0, 0.0), OK, "setup", 0);
    require(fmi2EnterInitializationMode(slave), OK, "enter", 0);
    require(fmi2ExitInitializationMode(slave), OK, "exit", 0);
}

static int step(Slave slave, double t, double h) { return fmi2DoStep(slave, t, h, 1); }

static void update(Slave slave) {
    fmi2EventInfo info;
    require(fmi2NewDiscreteStates(slave, &info), OK, "update", 0);
}

static int derivatives(Slave slave, double values[], size_t n) {
    return fmi2GetDerivatives(slave, values, n);
}

static int slopes(Slave slave, const uint32_t *of, const uint32_t *by, double *value) {
    const double seed = 1.0;
    return fmi2GetDirectionalDerivative(slave, of, 1, by, 1, &seed, value);
}
#else
static void hear(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                 fmi3String message) {
    (void)environment, (void)status, (void)category, (void)message;
    messages++;
}

static Slave instantiate(const char *token, int model_exchange) {
    if (model_exchange)
        return fmi3InstantiateModelExchange("driver", token, "", 0, 1, NULL, hear);
    return fmi3InstantiateCoSimulation("driver", token, "", 0, 1, 0, 0, NULL, 0, NULL, hear, NULL);
}

static void initialize(Slave slave) {
    require(fmi3EnterInitializationMode(slave, 0, 0.0, 0.0, 0, 0.0), OK, "enter", 0);
    require(fmi3ExitInitializationMode(slave), OK, "exit", 0);
}

static int step(Slave slave, double t, double h) {
    bool event, terminate, early;
    double last;
    return fmi3DoStep(slave, t, h, true, &event, &terminate, &early, &last);
}

static void update(Slave slave) {
    bool again, terminate, nominals, values, defined;
    double next;
    require(
        fmi3UpdateDiscreteStates(slave, &again, &terminate, &nominals, &values, &defined, &next),
        OK, "update", 0);
}

static int derivatives(Slave slave, double values[], size_t n) {
    return fmi3GetContinuousStateDerivatives(slave, values, n);
}

static int slopes(Slave slave, const uint32_t *of, const uint32_t *by, double *value) {
    const double seed = 1.0;
    double transposed;
    const int status = fmi3GetDirectionalDerivative(slave, of, 1, by, 1, &seed, 1, value, 1);
    require(fmi3GetAdjointDerivative(slave, of, 1, by, 1, &seed, 1, &transposed, 1), status,
            "adjoint", *of);
    return status;
}
#endif

/* Set variable k as its type wants it. */
static int set(Slave slave, uint32_t k, double value) {
    const int32_t whole = fabs(value) < INT32_MAX ? (int32_t)value : INT32_MAX;
    const Boolean truth = value != 0.0;
    switch (VARIABLES[k].type) {
    case REAL:
        return SET(Real, Float64, slave, &k, &value);
    case INTEGER:
        return SET(Integer, Int32, slave, &k, &whole);
    default:
        return SET(Boolean, Boolean, slave, &k, &truth);
    }
}

static double get(Slave slave, uint32_t k) {
    double value = 0.0;
    int32_t whole = 0;
    Boolean truth = 0;
    switch (VARIABLES[k].type) {
    case REAL:
    case DERIVATIVE:
        require(GET(Real, Float64, slave, &k, &value), OK, "get", k);
        return value;
    case INTEGER:
        require(GET(Integer, Int32, slave, &k, &whole), OK, "get", k);
        return whole;
    default:
        require(GET(Boolean, Boolean, slave, &k, &truth), OK, "get", k);
        return truth;
    }
}

/* A factor times the start value, within the range. */
static double tuned(uint32_t k, double factor) {
    const double value = VARIABLES[k].start * factor;
    return value < VARIABLES[k].maximum ? value : VARIABLES[k].maximum;
}

/* Step with inputs that turn and tunable parameters that change. */
static void run(Slave slave, int first, int last) {
    const double h = 5e-4;
    for (int n = first; n < last; n++) {
        for (uint32_t k = 0; k < PARAMETERS_AT; k++)
            if (VARIABLES[k].settable & STEPPING)
                require(set(slave, k, n % 40 < 20 ? 0.02 * k : -0.03), OK, "set input", k);
        for (uint32_t k = PARAMETERS_AT; k < COUNT; k++)
            if (VARIABLES[k].settable & STEPPING)
                require(set(slave, k, tuned(k, 1.0 + n % 3)), OK, "set tunable", k);
        require(step(slave, n * h, h), OK, "step", 0);
        for (uint32_t k = 0; k < COUNT; k++)
            get(slave, k);
    }
}

/* Every pair of variables: those that are no derivative, output, state or input are refused. */
static void differentiate(Slave slave) {
    for (uint32_t of = 0; of <= COUNT; of++)
        for (uint32_t by = 0; by <= COUNT; by++) {
            double value;
            const bool known = (by >= INPUTS_AT && by < INPUTS_AT + INPUTS_COUNT) ||
                               (by >= STATES_AT && by < STATES_AT + STATES_COUNT);
            const bool unknown = of >= STATES_AT && of < OUTPUTS_AT + OUTPUTS_COUNT;
            const int expected = IS_CONTINUOUS && known && unknown ? OK : ERROR;
            require(slopes(slave, &of, &by, &value), expected, "differentiate", of);
        }
}

/* As a solver that takes Euler steps would. */
static void exchange(void) {
    Slave slave = instantiate(MODEL_TOKEN, 1);
    require(slave != NULL, HAS_MODEL_EXCHANGE, "instantiate for exchange", 0);
    if (!slave)
        return;
    double x[COUNT], dx[COUNT];
    initialize(slave);
    require(step(slave, 0.0, 1e-3), ERROR, "step in exchange", 0);
    for (int n = 0; n < 100; n++) {
        update(slave);
        require(CALL(EnterContinuousTimeMode, EnterContinuousTimeMode, slave), OK, "continue", 0);
        require(CALL(SetTime, SetTime, slave, n * 1e-5), OK, "time", 0);
        require(derivatives(slave, dx, DERIVATIVES_COUNT), OK, "derivatives", 0);
        require(derivatives(slave, dx, DERIVATIVES_COUNT + 1), ERROR, "too many", 0);
        require(CALL(GetContinuousStates, GetContinuousStates, slave, x, DERIVATIVES_COUNT), OK,
                "states", 0);
        for (int k = 0; k < DERIVATIVES_COUNT; k++)
            x[k] += 1e-5 * dx[k];
        require(CALL(SetContinuousStates, SetContinuousStates, slave, x, DERIVATIVES_COUNT), OK,
                "set states", 0);
        for (uint32_t k = 0; k < COUNT; k++)
            get(slave, k);
        require(CALL(EnterEventMode, EnterEventMode, slave), OK, "event", 0);
    }
    differentiate(slave);
    require(CALL(Terminate, Terminate, slave), OK, "terminate", 0);
    CALL(FreeInstance, FreeInstance, slave);
}

int main(void) {
    if (instantiate("stale", 0) || messages != 1)
        return 1;
    exchange();
    Slave slave = instantiate(MODEL_TOKEN, 0);
    if (!slave)
        return 1;
    for (uint32_t k = PARAMETERS_AT; k < COUNT; k++)
        if (VARIABLES[k].type != REAL)
            require(set(slave, k, 1.0), OK, "switch on", k);
    require(step(slave, 0.0, 1e-3), ERROR, "step too early", 0);
    initialize(slave);
    run(slave, 0, 100);
    differentiate(slave);

    State state = NULL, copy = NULL;
    size_t size = 0;
    require(CALL(GetFMUstate, GetFMUState, slave, &state), OK, "save", 0);
    require(CALL(GetFMUstate, GetFMUState, slave, &state), OK, "save once more", 0);
    require(CALL(SerializedFMUstateSize, SerializedFMUStateSize, slave, state, &size), OK, "size",
            0);
    Byte *bytes = malloc(size);
    if (!bytes)
        return 1;
    require(CALL(SerializeFMUstate, SerializeFMUState, slave, state, bytes, size), OK, "write", 0);
    require(CALL(DeSerializeFMUstate, DeserializeFMUState, slave, bytes, size, &copy), OK, "read",
            0);
    require(CALL(DeSerializeFMUstate, DeserializeFMUState, slave, bytes, size - 1, &copy), ERROR,
            "read too little", 0);
    free(bytes);
    run(slave, 100, 150);
    require(CALL(SetFMUstate, SetFMUState, slave, copy), OK, "restore", 0);
    run(slave, 100, 150);
    require(CALL(FreeFMUstate, FreeFMUState, slave, &state), OK, "free", 0);
    require(CALL(FreeFMUstate, FreeFMUState, slave, &copy), OK, "free", 0);

    /* What a tool may get wrong. */
    for (uint32_t k = 0; k < COUNT; k++) {
        (void)set(slave, k, 1e308);
        (void)set(slave, k, -1.0);
    }
    const uint32_t beyond = COUNT;
    double value = 0.0;
    require(SET(Real, Float64, slave, &beyond, &value), ERROR, "set nothing", beyond);
    require(GET(Real, Float64, slave, &beyond, &value), ERROR, "get nothing", beyond);
    (void)step(slave, 0.075, 5e-4);

    require(CALL(Reset, Reset, slave), OK, "reset", 0);
    initialize(slave);
    run(slave, 0, 20);
    require(CALL(Terminate, Terminate, slave), OK, "terminate", 0);
    CALL(FreeInstance, FreeInstance, slave);
    CALL(FreeInstance, FreeInstance, NULL);
    return 0;
}
