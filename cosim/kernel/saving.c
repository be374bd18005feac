/* Saves and restores an FMU on the general path: its state, its time, its clocks and the inputs it
 * was given. What follows from these is found again. */
#include "general_path.h"
#include <stdlib.h>
#include <string.h>

typedef struct {
    void *state;
    double time, next_event, passed;
    Clock *clocks;   /* n_clocks */
    double inputs[]; /* before and after, 2 n_inputs */
} Saved;

static size_t inputs_size(const GeneralComponent *f) { return f->n_inputs * sizeof(double); }
static size_t clocks_size(const GeneralComponent *f) { return f->n_clocks * sizeof(Clock); }

/* As the standard wants it, *state is NULL or an earlier one, which is overwritten. */
fmi2Status general_GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
    GeneralComponent *f = c;
    Saved *saved = *state;
    if (!saved) {
        saved = *state = calloc(1, sizeof *saved + 2 * inputs_size(f) + clocks_size(f));
    }
    if (!saved) {
        return failed_by(f, GET_STATE, OUT_OF_MEMORY);
    }
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
    if (!f->integrator) {
        return fmi2OK;
    }
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
