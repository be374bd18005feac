#include "instance.h"

#include <stdarg.h>
#include <string.h>

#include "heap.h"
#include "model.h"
#include "text.h"

#define STATES(i) ((States *)(i->now.values + STATES_AT))
#define MEMORY(i) ((Memory *)(i->now.values + MEMORY_AT))
#define INPUTS(i) ((const Inputs *)(i->now.values + INPUTS_AT))
#define PARAMETERS(i) ((const Parameters *)(i->now.values + PARAMETERS_AT))
#define DERIVATIVES(i) ((Derivatives *)(i->now.values + DERIVATIVES_AT))
#define OUTPUTS(i) ((Outputs *)(i->now.values + OUTPUTS_AT))

static const char *phase_name(Phase phase) {
    static const char *const NAMES[] = {
        "instantiated", "initialization mode", "step mode",           "terminated",
        "failed",       "event mode",          "continuous-time mode"};
    int bit = 0;
    while ((int)phase >> bit > 1)
        bit++;
    return NAMES[bit];
}

Status instance_report(Instance *i, Status status, const char *category, const char *format, ...) {
    char message[512];
    va_list arguments;
    va_start(arguments, format);
    text_write(message, sizeof message, format, arguments);
    va_end(arguments);
    if (i->logger.callback && (status != OK || i->logger.events))
        i->logger.emit(&i->logger, i->name, status, category, message);
    return status;
}

static void load_start_values(Instance *i) {
    i->now = (Snapshot){.phase = INSTANTIATED, .stale = true};
    for (size_t k = 0; k < COUNT; k++)
        i->now.values[k] = START.values[k];
}

Instance *instance_new(const char *name, const char *token, const char *resources,
                       bool model_exchange, Logger logger) {
    size_t length = 0;
    while (name && name[length])
        length++;
    Instance *i = heap_get(sizeof *i + length + 1);
    if (!i)
        return NULL;
    i->logger = logger;
    i->model_exchange = model_exchange;
    for (size_t k = 0; k < length; k++)
        i->name[k] = name[k];
    if (!token || !text_equal(token, START.token)) {
        instance_report(
            i, ERROR, "logStatusError",
            "this binary has the token %s but was given %s: modelDescription.xml is of another "
            "build",
            START.token, token ? token : "none");
        instance_free(i);
        return NULL;
    }
    if (model_exchange && !IS_CONTINUOUS && !IS_SAMPLED) {
        instance_unavailable(i, "Model Exchange");
        instance_free(i);
        return NULL;
    }
    load_start_values(i);
    return i;
}

void instance_free(Instance *i) {
    if (i)
        instance_forget_all(i);
    heap_free(i);
}

Status instance_require(Instance *i, int phases, const char *call) {
    if ((int)i->now.phase & phases)
        return OK;
    return instance_report(i, ERROR, "logStatusError", "%s is not allowed in phase '%s'", call,
                           phase_name(i->now.phase));
}

Status instance_set_time(Instance *i, double start) {
    if (!is_finite(start))
        return instance_report(i, ERROR, "logStatusError", "start time %g s is not finite", start);
    i->now.values[0] = start;
    return OK;
}

Status instance_set_up(Instance *i, double start, bool stop_defined, double stop) {
    return instance_set_time(i, start);
}

double instance_time(const Instance *i) { return i->now.values[0]; }

static void start_model(Instance *i) {
    model_start(i->now.values[0], STATES(i), MEMORY(i), INPUTS(i), PARAMETERS(i));
}

bool instance_switch(Instance *i) {
#if IS_SWITCHED
    return model_switch(i->now.values[0], STATES(i), INPUTS(i), PARAMETERS(i));
#else
    return false;
#endif
}

/* Set the modes, and nothing else, to those that the present values ask for. */
static void settle(Instance *i) {
#if IS_SWITCHED
    double *values = i->now.values, continuous[DERIVATIVES_COUNT];
    for (size_t k = MODES_AT; k < MODES_AT + MODES_COUNT; k++)
        values[k] = 0.0;
    memcpy(continuous, values + STATES_AT, sizeof continuous);
    instance_switch(i);
    memcpy(values + STATES_AT, continuous, sizeof continuous);
#else
    (void)i;
#endif
}

/* Derivatives, event indicators, and outputs as functions of the state alone, in the present modes:
 * those that events have set, or, before events and with steps, those that settle. */
static void evaluate(Instance *i, Outputs *y) {
#if IS_SWITCHED
    double *values = i->now.values, states[STATES_COUNT];
    memcpy(states, values + STATES_AT, sizeof states);
    if (!i->model_exchange || i->now.phase & (INSTANTIATED | INITIALIZATION))
        settle(i);
    model_events(values[0], STATES(i), INPUTS(i), PARAMETERS(i),
                 (Indicators *)(values + INDICATORS_AT));
#endif
#if IS_CONTINUOUS
    model_continuous(i->now.values[0], STATES(i), INPUTS(i), PARAMETERS(i), DERIVATIVES(i), y);
#endif
#if IS_SWITCHED
    memcpy(values + STATES_AT, states, sizeof states);
#endif
#if !IS_CONTINUOUS
    (void)i, (void)y;
#endif
}

void instance_refresh(Instance *i) {
    if (!i->now.stale)
        return;
    if (i->now.phase & (INSTANTIATED | INITIALIZATION))
        start_model(i);
    if (IS_CONTINUOUS && i->model_exchange)
        evaluate(i, OUTPUTS(i));
    else
        model_outputs(i->now.values[0], STATES(i), MEMORY(i), INPUTS(i), PARAMETERS(i), OUTPUTS(i));
    i->now.stale = false;
}

Status instance_enter_initialization(Instance *i) {
    i->now.phase = INITIALIZATION;
    i->now.stale = true;
    return OK;
}

Status instance_exit_initialization(Instance *i) {
    instance_refresh(i);
    i->now.phase = i->model_exchange ? EVENT : STEPPING;
    if (i->model_exchange)
        settle(i);
    return instance_report(i, OK, "logEvents", "initialized at t = %g s", i->now.values[0]);
}

Status instance_step(Instance *i, double time, double h) {
    if (!(h > 0.0) || !is_finite(time) || !is_finite(h))
        return instance_report(
            i, ERROR, "logStatusError",
            "a step of %g s from t = %g s is not possible; the step must be positive", h, time);
    const bool done = model_step(time, h, STATES(i), MEMORY(i), INPUTS(i), PARAMETERS(i));
    i->now.values[0] = time + h;
    i->now.stale = true;
    instance_refresh(i);
    if (done)
        return OK;
    i->now.phase = BROKEN;
    return instance_report(
        i, ERROR, "logStatusError",
        "the state is not finite after the step from t = %g s to %g s, or the step"
        " is too long",
        time, time + h);
}

Status instance_terminate(Instance *i) {
    i->now.phase = ENDED;
    return OK;
}

Status instance_reset(Instance *i) {
    load_start_values(i);
    return OK;
}

Status instance_check(Instance *i, uint32_t reference, Type type, const char *call) {
    if (reference >= COUNT)
        return instance_report(i, ERROR, "logStatusError",
                               "%s: value reference %lu does not exist; the last one is %d", call,
                               (unsigned long)reference, COUNT - 1);
    if (VARIABLES[reference].type == type)
        return OK;
    if (VARIABLES[reference].type != DERIVATIVE || type != REAL)
        return instance_report(i, ERROR, "logStatusError", "%s: variable %s is of another type",
                               call, VARIABLES[reference].name);
    if (!i->model_exchange) {
        double unused[OUTPUTS_COUNT + 1];
        evaluate(i, (Outputs *)unused);
    }
    return OK;
}

Status instance_get(Instance *i, uint32_t reference, Type type, double *value, const char *call) {
    instance_refresh(i);
    if (instance_check(i, reference, type, call) != OK)
        return ERROR;
    *value = i->now.values[reference];
    return OK;
}

Status instance_lacks(Instance *i, const char *call) {
    return instance_report(i, ERROR, "logStatusError", "%s: an argument is NULL", call);
}

Status instance_mismatch(Instance *i, size_t references, size_t values, const char *call) {
    return instance_report(i, ERROR, "logStatusError", "%s: %zu values for %zu scalar variables",
                           call, values, references);
}

Status instance_unavailable(Instance *i, const char *call) {
    if (!i)
        return ERROR;
    return instance_report(i, ERROR, "logStatusError", "%s is not available", call);
}

Status instance_accepts(Instance *i, uint32_t reference, Type type, double value,
                        const char *call) {
    if (instance_check(i, reference, type, call) != OK)
        return ERROR;
    const Variable *variable = &VARIABLES[reference];
    if (!((int)i->now.phase & variable->settable))
        return instance_report(i, ERROR, "logStatusError", "%s: %s cannot be set in phase '%s'",
                               call, variable->name, phase_name(i->now.phase));
    if (!(value >= variable->minimum && value <= variable->maximum))
        return instance_report(i, ERROR, "logStatusError", "%s: %s = %g is outside %g .. %g", call,
                               variable->name, value, variable->minimum, variable->maximum);
    return OK;
}

Status instance_put(Instance *i, uint32_t reference, double value) {
    i->now.values[reference] = value;
    i->now.stale = true;
    return OK;
}

Status instance_log(Instance *i, bool on, size_t count, const char *const categories[]) {
    bool events = count == 0;
    for (size_t k = 0; k < count; k++) {
        if (!categories[k])
            return instance_lacks(i, "SetDebugLogging");
        events =
            events || text_equal(categories[k], "logEvents") || text_equal(categories[k], "logAll");
    }
    i->logger.events = on && events;
    return OK;
}
