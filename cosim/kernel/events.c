/* Events, in the event mode of the FMU, with the clocks of FMI 3.0: input clocks that tick by time,
 * and triggered ones, which are signals. */
#include "general_path.h"

fmi2Status trigger_clocks(GeneralComponent *f) {
    for (size_t i = 0; i < f->inputs.n; i++) {
        const Group *g = &f->inputs.groups[i];
        bool *ticks = g->values;
        for (size_t j = 0; g->clock && j < g->n; j++) {
            const bool tick = ticks[j];
            ticks[j] = false;
            MARK_CALL(g->name);
            if (tick) {
                TRY_STATUS(noted(
                    f, g->name,
                    (int)((fmi3SetClockTYPE *)g->call)(f->instance, &g->references[j], 1, &tick)));
            }
        }
    }
    return fmi2OK;
}

static fmi2Status note_ticks(GeneralComponent *f) {
    for (size_t i = 0; i < f->outputs.n; i++) {
        const Group *g = &f->outputs.groups[i];
        bool *ticks = g->values;
        for (size_t j = 0; g->clock && j < g->n; j++) {
            bool tick = false;
            MARK_CALL(g->name);
            TRY_STATUS(noted(
                f, g->name,
                (int)((fmi3GetClockTYPE *)g->call)(f->instance, &g->references[j], 1, &tick)));
            ticks[j] = ticks[j] || tick;
        }
    }
    return fmi2OK;
}

void forget_ticks(GeneralComponent *f) {
    for (size_t i = 0; f->ticks_read && i < f->outputs.n; i++) {
        const Group *g = &f->outputs.groups[i];
        for (size_t j = 0; g->clock && j < g->n; j++)
            ((bool *)g->values)[j] = false;
    }
    f->ticks_read = 0;
}

static fmi2Status ask(GeneralComponent *f, Clock *clock, fmi3IntervalQualifier *qualifier) {
    AnyCall *call = calling(f, GET_INTERVAL);
    *qualifier = fmi3IntervalNotYetKnown;
    return checked(f, GET_INTERVAL,
                   (int)((fmi3GetIntervalDecimalTYPE *)call)(f->instance, &clock->reference, 1,
                                                             &clock->interval, qualifier));
}

void schedule_ticks(GeneralComponent *f) {
    f->next_tick = INFINITY;
    for (size_t i = 0; i < f->n_clocks; i++)
        f->next_tick = fmin(f->next_tick, f->clocks[i].next);
}

fmi2Status begin_clocks(GeneralComponent *f) {
    for (size_t i = 0; i < f->n_clocks; i++) {
        Clock *clock = &f->clocks[i];
        fmi3IntervalQualifier qualifier;
        clock->ticks = 0;
        clock->begin = f->start + clock->shift;
        clock->next = clock->asked == AT_EVENTS ? INFINITY : clock->begin;
        if (clock->asked == ONCE || clock->asked == AT_TICKS)
            TRY_STATUS(ask(f, clock, &qualifier));
    }
    schedule_ticks(f);
    return fmi2OK;
}

/* Before the discrete states are updated. */
static fmi2Status tick_clocks(GeneralComponent *f) {
    AnyCall *call = calling(f, SET_CLOCK);
    const bool tick = true;
    for (size_t i = 0; i < f->n_clocks; i++) {
        Clock *clock = &f->clocks[i];
        if (is_due(f, clock->next, f->time)) {
            TRY_STATUS(
                checked(f, SET_CLOCK,
                        (int)((fmi3SetClockTYPE *)call)(f->instance, &clock->reference, 1, &tick)));
        }
    }
    return fmi2OK;
}

/* When will those that ticked tick again? Begin and number of ticks give the time of periodic
 * clocks, so that no rounding adds up. */
static fmi2Status after_ticks(GeneralComponent *f) {
    for (size_t i = 0; i < f->n_clocks; i++) {
        Clock *clock = &f->clocks[i];
        fmi3IntervalQualifier qualifier = fmi3IntervalUnchanged;
        const bool ticked = is_due(f, clock->next, f->time);
        if (clock->asked == AT_EVENTS || (ticked && clock->asked == AT_TICKS))
            TRY_STATUS(ask(f, clock, &qualifier));
        if (clock->asked == AT_EVENTS) {
            clock->next = ticked ? INFINITY : clock->next;
            clock->next =
                qualifier == fmi3IntervalChanged ? f->time + clock->interval : clock->next;
        } else if (ticked && qualifier == fmi3IntervalChanged) {
            clock->begin = f->time;
            clock->ticks = 1;
            clock->next = clock->begin + clock->interval;
        } else if (ticked) {
            clock->next = clock->begin + (double)++clock->ticks * clock->interval;
        }
    }
    schedule_ticks(f);
    return fmi2OK;
}

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
        if (terminate)
            return failed_by(f, UPDATE_DISCRETE_STATES, TERMINATED);
        TRY_STATUS(again ? fmi2OK : after_ticks(f));
        if (!again && !is_due(f, f->next_tick, f->time))
            return fmi2OK;
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
