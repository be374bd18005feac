/* The general path as the kernel sees it: the functions of a plain FMI 2.0 FMU. They call what lies
 * in the other files: calls <- values <- events <- exchange <- saving; each may use those before
 * it. */
#include "general_path.h"
#include <math.h>

fmi2Component general_Instantiate(fmi2String name, fmi2Type type, fmi2String token,
                                  fmi2String resources, const fmi2CallbackFunctions *callbacks,
                                  fmi2Boolean visible, fmi2Boolean logging) {
    GeneralComponent *f = (GeneralComponent *)(uintptr_t)callbacks;
    void *environment = callbacks->componentEnvironment;
    AnyCall *call = calling(f, f->model_exchange ? INSTANTIATE_ME : INSTANTIATE_CS);
    if (f->version == 2) {
        type = f->model_exchange ? fmi2ModelExchange : fmi2CoSimulation;
        f->instance = ((fmi2InstantiateTYPE *)call)(name, type, token, resources, callbacks,
                                                    visible, logging);
    } else if (f->model_exchange) {
        f->instance = ((fmi3InstantiateModelExchangeTYPE *)call)(
            name, token, resources, visible != 0, logging != 0, environment, log_fmi3);
    } else {
        const bool events = f->event_mode;
        f->instance = ((fmi3InstantiateCoSimulationTYPE *)call)(
            name, token, resources, visible != 0, logging != 0, events, events, NULL, 0,
            environment, log_fmi3, NULL);
    }
    return f->instance ? f : NULL;
}

void general_FreeInstance(fmi2Component c) {
    GeneralComponent *f = c;
    end_exchange(f);
    if (f->instance && f->begun)
        ((StateCall *)calling(f, FREE_STATE))(f->instance, &f->begun);
    f->begun = NULL;
    if (f->instance)
        ((void (*)(void *))calling(f, FREE_INSTANCE))(f->instance);
    f->instance = NULL;
}

fmi2Status general_Reset(fmi2Component c) {
    GeneralComponent *f = c;
    end_exchange(f);
    return simple_call(f, RESET);
}

fmi2Status general_SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                   fmi2Real start, fmi2Boolean has_stop, fmi2Real stop) {
    GeneralComponent *f = c;
    f->time = f->start = start;
    f->stop = has_stop ? stop : INFINITY;
    f->own_tolerance = has_tolerance ? tolerance : 0.0;
    f->next_event = f->next_tick = INFINITY;
    f->running = 0;
    f->called = NULL;
    if (f->version == 3)
        return fmi2OK;
    AnyCall *call = calling(f, SETUP_EXPERIMENT);
    return checked(f, SETUP_EXPERIMENT,
                   (int)((fmi2SetupExperimentTYPE *)call)(f->instance, has_tolerance, tolerance,
                                                          start, has_stop, stop));
}

fmi2Status general_EnterInitializationMode(fmi2Component c) {
    GeneralComponent *f = c;
    if (f->structure.n) {
        TRY_STATUS(simple_call(f, ENTER_CONFIGURATION));
        TRY_STATUS(set_groups(f, &f->structure));
        TRY_STATUS(simple_call(f, EXIT_CONFIGURATION));
    }
    TRY_STATUS(set_groups(f, &f->start_values));
    if (f->version == 2) {
        TRY_STATUS(simple_call(f, ENTER_INITIALIZATION));
    } else {
        AnyCall *call = calling(f, ENTER_INITIALIZATION);
        TRY_STATUS(checked(f, ENTER_INITIALIZATION,
                           (int)((fmi3EnterInitializationModeTYPE *)call)(
                               f->instance, f->own_tolerance > 0.0, f->own_tolerance, f->start,
                               isfinite(f->stop), f->stop)));
    }
    return set_groups(f, &f->late);
}

fmi2Status general_ExitInitializationMode(fmi2Component c) {
    GeneralComponent *f = c;
    TRY_STATUS(simple_call(f, EXIT_INITIALIZATION));
    if (f->model_exchange || f->event_mode) {
        TRY_STATUS(begin_clocks(f));
        TRY_STATUS(trigger_clocks(f));
        TRY_STATUS(update_discrete_states(f));
        TRY_STATUS(simple_call(f, f->model_exchange ? ENTER_CONTINUOUS_TIME : ENTER_STEP_MODE));
    }
    if (f->model_exchange)
        TRY_STATUS(begin_exchange(f));
    f->running = 1;
    return fmi2OK;
}

fmi2Status general_Terminate(fmi2Component c) { return simple_call(c, TERMINATE); }

/* While a run goes on, a discrete input that changed is an event where the FMU knows events; Model
 * Exchange keeps the values until it steps. */
fmi2Status general_SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n,
                           const fmi2Real values[]) {
    GeneralComponent *f = c;
    const bool event = take_values(f, r, n, values);
    if (f->running && f->model_exchange)
        return fmi2OK;
    return f->running && f->event_mode && event ? handle_event(f, true) : set_taken(f);
}

/* Of Model Exchange, which follows the polynomials of a coupling in its next step. */
fmi2Status general_SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                           const fmi2Integer orders[], const fmi2Real values[]) {
    GeneralComponent *f = c;
    for (size_t i = 0; i < n; i++)
        f->rates[(size_t)(orders[i] - 1) * f->n_inputs + r[i]] = values[i];
    return fmi2OK;
}

fmi2Status general_GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n,
                           fmi2Real values[]) {
    GeneralComponent *f = c;
    TRY_STATUS(get_values(f, r, n, values));
    f->ticks_read = 1;
    return fmi2OK;
}

fmi2Status general_tune(fmi2Component c, const fmi2ValueReference references[], size_t n,
                        const void *group) {
    GeneralComponent *f = c;
    (void)references, (void)n;
    if (!(f->event_mode || f->model_exchange))
        return transfer(f, group);
    TRY_STATUS(simple_call(f, ENTER_EVENT_MODE));
    TRY_STATUS(transfer(f, group));
    TRY_STATUS(update_discrete_states(f));
    TRY_STATUS(simple_call(f, f->model_exchange ? ENTER_CONTINUOUS_TIME : ENTER_STEP_MODE));
    return general_go_on(f);
}

static fmi2Status step_fmi2(GeneralComponent *f, double t, double h) {
    TRY_STATUS(step_once(f, t, h));
    f->time = t + h;
    return fmi2OK;
}

/* An FMU that returns early is sent on its way again until the step is done; it stops at ticks. */
static fmi2Status step_fmi3(GeneralComponent *f, double t, double h) {
    const double last = t + h;
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        const bool ticks = f->next_tick < last && !is_due(f, last, f->next_tick);
        const double end = ticks ? f->next_tick : last;
        h = ticks ? end - t : h;
        TRY_STATUS(step_once(f, t, h));
        const Answers *answers = &f->answers;
        const double reached = answers->last_successful_time;
        if (answers->early && !(reached >= t && reached <= end + f->near))
            return failed_by(f, DO_STEP, NO_SUCH_TIME);
        const bool whole = !answers->early || end - reached <= rounding_of(end);
        f->time = whole ? end : reached;
        if (answers->terminate)
            return failed_by(f, DO_STEP, TERMINATED);
        if (answers->early && !f->event_mode)
            return failed_by(f, DO_STEP, RETURNED_EARLY);
        if (f->event_mode && (answers->event_handling_needed || is_due(f, f->next_tick, f->time)))
            TRY_STATUS(handle_event(f, false));
        if (whole && !ticks)
            return fmi2OK;
        t = f->time;
        h = last - t;
    }
    return failed_by(f, DO_STEP, TOO_MANY_EVENTS);
}

fmi2Status general_DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_return) {
    GeneralComponent *f = c;
    (void)no_return;
    forget_ticks(f);
    if (f->model_exchange)
        return step_exchange(f, t, h);
    return (f->version == 2 ? step_fmi2(f, t, h) : step_fmi3(f, t, h));
}
