#include "instance.h"

#include "model.h"

Status exchange_update(Instance *i, bool *changed, bool *defined, double *next) {
    *changed = instance_switch(i);
    i->now.stale = i->now.stale || IS_SWITCHED;
    *defined = IS_SAMPLED;
    *next = 0.0;
#if IS_SAMPLED
    double *values = i->now.values;
    *next = model_sample(values[0], (Memory *)(values + MEMORY_AT),
                         (const Inputs *)(values + INPUTS_AT),
                         (const Parameters *)(values + PARAMETERS_AT));
    i->now.stale = true;
    if (!(*next > values[0]))
        return instance_report(i, ERROR, "logStatusError",
                               "t = %g s is too many samples after the last event", values[0]);
#endif
    return OK;
}

Status exchange_enter(Instance *i, Phase phase) {
    i->now.phase = phase;
    return OK;
}

Status exchange_set_time(Instance *i, double time) {
    const Status status = instance_set_time(i, time);
    i->now.stale = i->now.stale || status == OK;
    return status;
}

static Status require_number(Instance *i, size_t count, int expected, const char *what) {
    if (count == (size_t)expected)
        return OK;
    return instance_report(i, ERROR, "logStatusError", "%zu values for %d %s", count, expected,
                           what);
}

static Status require_count(Instance *i, size_t count) {
    return require_number(i, count, DERIVATIVES_COUNT, "continuous states");
}

Status exchange_set_states(Instance *i, const double states[], size_t count) {
    if (require_count(i, count) != OK)
        return ERROR;
    for (size_t k = 0; k < count; k++)
        if (!is_finite(states[k]))
            return instance_report(i, DISCARD, "logStatusDiscard", "%s = %g is not possible",
                                   VARIABLES[STATES_AT + k].name, states[k]);
    for (size_t k = 0; k < count; k++)
        i->now.values[STATES_AT + k] = states[k];
    i->now.stale = true;
    return OK;
}

Status exchange_get_states(Instance *i, double states[], size_t count) {
    if (require_count(i, count) != OK)
        return ERROR;
    for (size_t k = 0; k < count; k++)
        states[k] = i->now.values[STATES_AT + k];
    return OK;
}

Status exchange_get_derivatives(Instance *i, double derivatives[], size_t count) {
    if (require_count(i, count) != OK)
        return ERROR;
    instance_refresh(i);
    for (size_t k = 0; k < count; k++) {
        derivatives[k] = i->now.values[DERIVATIVES_AT + k];
        if (!is_finite(derivatives[k]))
            return instance_report(i, DISCARD, "logStatusDiscard", "%s is not finite at t = %g s",
                                   VARIABLES[DERIVATIVES_AT + k].name, i->now.values[0]);
    }
    return OK;
}

Status exchange_get_nominals(Instance *i, double nominals[], size_t count) {
    if (require_count(i, count) != OK)
        return ERROR;
    for (size_t k = 0; k < count; k++)
        nominals[k] = VARIABLES[STATES_AT + k].nominal;
    return OK;
}

size_t exchange_count(const Instance *i) { return DERIVATIVES_COUNT; }

size_t exchange_indicator_count(const Instance *i) { return INDICATORS_COUNT; }

Status exchange_get_indicators(Instance *i, double indicators[], size_t count) {
    if (require_number(i, count, INDICATORS_COUNT, "event indicators") != OK)
        return ERROR;
    instance_refresh(i);
    for (size_t k = 0; k < count; k++)
        indicators[k] = i->now.values[INDICATORS_AT + k];
    return OK;
}
