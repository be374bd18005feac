/* DoStep on the general path. A step that is discarded, where this is enabled, is taken back and
 * tried in parts. */
#include "general_path.h"

enum { MOST_PARTS = 1024 };

fmi2Status get_state(GeneralComponent *f, void **state) {
    TRY_STATUS(checked(f, GET_STATE, ((StateCall *)calling(f, GET_STATE))(f->instance, state)));
    return *state ? fmi2OK : failed_by(f, GET_STATE, NO_STATE);
}

fmi2Status set_state(GeneralComponent *f, void *state) {
    return checked(f, SET_STATE, ((RestoreCall *)calling(f, SET_STATE))(f->instance, state));
}

static int do_step(GeneralComponent *f, double t, double h) {
    AnyCall *call = calling(f, DO_STEP);
    Answers *answers = &f->answers;
    if (f->version == 2) {
        return (int)((fmi2DoStepTYPE *)call)(f->instance, t, h, !f->retries_steps);
    }
    *answers = (Answers){false, false, false, t + h};
    return (int)((fmi3DoStepTYPE *)call)(f->instance, t, h, !f->retries_steps,
                                         &answers->event_handling_needed, &answers->terminate,
                                         &answers->early, &answers->last_successful_time);
}

fmi2Status step_once(GeneralComponent *f, double t, double h) {
    if (!f->retries_steps) {
        return checked(f, DO_STEP, do_step(f, t, h));
    }
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
