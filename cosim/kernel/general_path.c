/* The life of an FMU on the general path, from instantiation to its end, with its events. */
#include "general_path.h"
#include <math.h>

/* More in a row mean that events never come to an end. */
enum { MAX_ITERATIONS = 10000 };

#define FMI2(place, fmi2, fmi3, interfaces) fmi2,
#define FMI3(place, fmi2, fmi3, interfaces) fmi3,
static const char *const NAMES[][N_CALLS] = {{GENERAL_CALLS(FMI2)}, {GENERAL_CALLS(FMI3)}};

#ifdef MARKED
AnyCall *calling(const GeneralComponent *f, enum Call place) {
    MARK_CALL(NAMES[f->version - 2][place]);
    return f->call[place];
}
#endif

/* A warning is checked here and OK for the kernel. */
fmi2Status noted(GeneralComponent *f, const char *call, int status) {
    restore_sums();
    if (status == fmi2OK) {
        return fmi2OK;
    }
    if (status == fmi2Warning) {
        note_warning(&f->log, call, f->time);
        return fmi2OK;
    }
    f->called = call;
    if (status == fmi2Fatal) {
        f->instance = NULL;
    }
    if ((unsigned)status > (f->version == 2 ? (unsigned)fmi2Pending : (unsigned)fmi3Fatal)) {
        f->log.unknown = status;
        f->log.reason = status = UNKNOWN_STATUS;
    }
    return (fmi2Status)status;
}

fmi2Status checked(GeneralComponent *f, enum Call place, int status) {
    return noted(f, NAMES[f->version - 2][place], status);
}

fmi2Status failed_by(GeneralComponent *f, enum Call place, int reason) {
    f->called = NAMES[f->version - 2][place];
    f->log.reason = reason;
    return (fmi2Status)reason;
}

fmi2Status simple_call(GeneralComponent *f, enum Call place) {
    return checked(f, place, ((int (*)(void *))calling(f, place))(f->instance));
}

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
    if (f->instance && f->begun) {
        ((StateCall *)calling(f, FREE_STATE))(f->instance, &f->begun);
    }
    f->begun = NULL;
    if (f->instance) {
        ((void (*)(void *))calling(f, FREE_INSTANCE))(f->instance);
    }
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
    if (f->version == 3) {
        return fmi2OK;
    }
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
    if (f->model_exchange) {
        TRY_STATUS(begin_exchange(f));
    }
    f->running = 1;
    return fmi2OK;
}

fmi2Status general_Terminate(fmi2Component c) { return simple_call(c, TERMINATE); }

/* Once: whether another call is due, and whether the FMU wants to end. */
static fmi2Status update_once(GeneralComponent *f, bool *again, bool *terminate) {
    AnyCall *call = calling(f, UPDATE_DISCRETE_STATES);
    bool nominals, states, defined;
    double next;
    int status;
    if (f->version == 2) {
        fmi2EventInfo info = {0};
        status = (int)((fmi2NewDiscreteStatesTYPE *)call)(f->instance, &info);
        *again = info.newDiscreteStatesNeeded;
        *terminate = info.terminateSimulation;
        nominals = info.nominalsOfContinuousStatesChanged;
        states = info.valuesOfContinuousStatesChanged;
        defined = info.nextEventTimeDefined;
        next = info.nextEventTime;
    } else {
        nominals = states = defined = *again = *terminate = false;
        next = INFINITY;
        status = (int)((fmi3UpdateDiscreteStatesTYPE *)call)(f->instance, again, terminate,
                                                             &nominals, &states, &defined, &next);
    }
    f->states_changed = f->states_changed || nominals || states;
    f->next_event = defined ? next : INFINITY;
    TRY_STATUS(checked(f, UPDATE_DISCRETE_STATES, status));
    return isnan(f->next_event) ? failed_by(f, UPDATE_DISCRETE_STATES, NO_SUCH_TIME) : fmi2OK;
}

/* Until nothing is due any more. */
fmi2Status update_discrete_states(GeneralComponent *f) {
    f->states_changed = 0;
    forget_ticks(f);
    bool again = false, terminate;
    for (int i = 0; i < MAX_ITERATIONS; i++) {
        TRY_STATUS(again ? fmi2OK : tick_clocks(f));
        TRY_STATUS(note_ticks(f));
        TRY_STATUS(update_once(f, &again, &terminate));
        if (terminate) {
            return failed_by(f, UPDATE_DISCRETE_STATES, TERMINATED);
        }
        TRY_STATUS(again ? fmi2OK : after_ticks(f));
        if (!again && !is_due(f, f->next_tick, f->time)) {
            return fmi2OK;
        }
    }
    return failed_by(f, UPDATE_DISCRETE_STATES, TOO_MANY_EVENTS);
}

fmi2Status handle_event(GeneralComponent *f, bool with_inputs) {
    TRY_STATUS(simple_call(f, ENTER_EVENT_MODE));
    if (with_inputs) {
        TRY_STATUS(trigger_clocks(f));
        TRY_STATUS(set_groups(f, &f->inputs));
    }
    TRY_STATUS(update_discrete_states(f));
    return simple_call(f, f->model_exchange ? ENTER_CONTINUOUS_TIME : ENTER_STEP_MODE);
}

fmi2Status general_tune(fmi2Component c, const fmi2ValueReference references[], size_t n,
                        const void *group) {
    GeneralComponent *f = c;
    (void)references, (void)n;
    if (!(f->event_mode || f->model_exchange)) {
        return transfer(f, group);
    }
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
        if (answers->early && !(reached >= t && reached <= end + f->near)) {
            return failed_by(f, DO_STEP, NO_SUCH_TIME);
        }
        const bool whole = !answers->early || end - reached <= rounding_of(end);
        f->time = whole ? end : reached;
        if (answers->terminate) {
            return failed_by(f, DO_STEP, TERMINATED);
        }
        if (answers->early && !f->event_mode) {
            return failed_by(f, DO_STEP, RETURNED_EARLY);
        }
        if (f->event_mode && (answers->event_handling_needed || is_due(f, f->next_tick, f->time))) {
            TRY_STATUS(handle_event(f, false));
        }
        if (whole && !ticks) {
            return fmi2OK;
        }
        t = f->time;
        h = last - t;
    }
    return failed_by(f, DO_STEP, TOO_MANY_EVENTS);
}

fmi2Status general_DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_return) {
    GeneralComponent *f = c;
    (void)no_return;
    forget_ticks(f);
    if (f->model_exchange) {
        return step_exchange(f, t, h);
    }
    return (f->version == 2 ? step_fmi2(f, t, h) : step_fmi3(f, t, h));
}
