/* Saves and restores an FMU on the general path: its state, its time, its clocks and the inputs it
 * was given, from which the rest follows; and steps that are taken back and tried again. */
#include "general_path.h"
#include <stdlib.h>
#include <string.h>

enum { MOST_PARTS = 1024 }; /* of a step that is tried again */

typedef struct {
    void *state;
    double time, next_event, passed;
    Clock *clocks;   /* n_clocks */
    double inputs[]; /* before and after, 2 n_inputs */
} Saved;

static size_t inputs_size(const GeneralComponent *f) { return f->n_inputs * sizeof(double); }
static size_t clocks_size(const GeneralComponent *f) { return f->n_clocks * sizeof(Clock); }

static fmi2Status get_state(GeneralComponent *f, void **state) {
    TRY_STATUS(checked(f, GET_STATE, ((StateCall *)calling(f, GET_STATE))(f->instance, state)));
    return *state ? fmi2OK : failed_by(f, GET_STATE, NO_STATE);
}

static fmi2Status set_state(GeneralComponent *f, void *state) {
    return checked(f, SET_STATE, ((RestoreCall *)calling(f, SET_STATE))(f->instance, state));
}

static int do_step(GeneralComponent *f, double t, double h) {
    AnyCall *call = calling(f, DO_STEP);
    Answers *answers = &f->answers;
    if (f->version == 2)
        return (int)((fmi2DoStepTYPE *)call)(f->instance, t, h, !f->retries_steps);
    *answers = (Answers){false, false, false, t + h};
    return (int)((fmi3DoStepTYPE *)call)(f->instance, t, h, !f->retries_steps,
                                         &answers->event_handling_needed, &answers->terminate,
                                         &answers->early, &answers->last_successful_time);
}

/* A step that is discarded, where this is enabled, is taken back and tried in parts. */
fmi2Status step_once(GeneralComponent *f, double t, double h) {
    if (!f->retries_steps)
        return checked(f, DO_STEP, do_step(f, t, h));
    for (int done = 0, parts = 1; done < parts;) {
        const double from = t + h * done / parts, to = t + h * (done + 1) / parts;
        TRY_STATUS(get_state(f, &f->begun));
        const int status = do_step(f, from, parts == 1 ? h : to - from);
        if (status == fmi2Discard && parts < MOST_PARTS) {
            TRY_STATUS(set_state(f, f->begun));
            parts *= 2;
            done *= 2;
            continue;
        }
        TRY_STATUS(checked(f, DO_STEP, status));
        if (f->answers.terminate || f->answers.early ||
            (f->event_mode && f->answers.event_handling_needed)) {
            f->answers.early = f->answers.early || done + 1 < parts;
            return fmi2OK;
        }
        done++;
    }
    return fmi2OK;
}

/* As the standard wants it, *state is NULL or an earlier one, which is overwritten. */
fmi2Status general_GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    GeneralComponent *f = c;
    Saved *saved = *state;
    if (!saved)
        saved = *state = calloc(1, sizeof *saved + 2 * inputs_size(f) + clocks_size(f));
    if (!saved)
        return failed_by(f, GET_STATE, OUT_OF_MEMORY);
    saved->time = f->time;
    saved->next_event = f->next_event;
    saved->passed = f->passed;
    saved->clocks = (Clock *)(saved->inputs + 2 * f->n_inputs);
    memcpy(saved->clocks, f->clocks, clocks_size(f));
    memcpy(saved->inputs, f->before, inputs_size(f));
    memcpy(saved->inputs + f->n_inputs, f->after, inputs_size(f));
    return get_state(f, &saved->state);
}

fmi2Status general_SetFMUstate(fmi2Component c, fmi2FMUstate state) {
    GeneralComponent *f = c;
    const Saved *saved = state;
    f->time = saved->time;
    f->next_event = saved->next_event;
    f->passed = saved->passed;
    memcpy(f->clocks, saved->clocks, clocks_size(f));
    memcpy(f->before, saved->inputs, inputs_size(f));
    memcpy(f->after, saved->inputs + f->n_inputs, inputs_size(f));
    TRY_STATUS(set_state(f, saved->state));
    return general_go_on(f);
}

fmi2Status general_go_on(GeneralComponent *f) {
    PLAIN_HERE;
    schedule_ticks(f);
    if (!f->integrator)
        return fmi2OK;
    seek_jump(f);
    return restart_exchange(f);
}

fmi2Status general_FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
    GeneralComponent *f = c;
    Saved *saved = *state;
    fmi2Status status = fmi2OK;
    if (saved) {
        if (saved->state && f->instance) {
            StateCall *call = (StateCall *)calling(f, FREE_STATE);
            status = checked(f, FREE_STATE, call(f->instance, &saved->state));
        }
        free(saved);
    }
    *state = NULL;
    return status;
}
