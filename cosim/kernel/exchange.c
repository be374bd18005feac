/* Model Exchange: integrates an FMU's states over one communication step with CVode (BDF, Newton),
 * and stops at its state, time and step events. The solver counts time from the start of the run:
 * it takes times for the same that differ by some rounding errors of what it counts. */
#include "cvode.h"
#include "general_path.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { MOST_STATES = 20000 };                            /* the solver's matrix is dense */
enum { MAX_EVENTS = 10000, MAX_SOLVER_STEPS = 1000000 }; /* in one communication step */
static const double LONGEST = 0.02; /* of a run: the longest solver step, as in FMPy */
static const double ROUNDING = 1e-12;

struct Integrator {
    void *context, *memory, *matrix, *solver;
    void *states, *tolerances; /* vectors */
    double *x, *atol;          /* their values, n */
    size_t n;                  /* at least 1: CVode needs a state even where the FMU has none */
    double begin, end;         /* of the communication step, s */
    bool moving;               /* an input changes within the step */
    fmi2Status status;         /* of an FMI call that CVode made */
    const char *discarded;     /* the last such call that returned discard */
};

static fmi2Status exchange(GeneralComponent *f, enum Call place, double *values, size_t n) {
    AnyCall *call = calling(f, place);
    return checked(f, place, ((int (*)(void *, double *, size_t))call)(f->instance, values, n));
}

static fmi2Status set_time(GeneralComponent *f, double t) {
    AnyCall *call = calling(f, SET_TIME);
    return checked(f, SET_TIME, ((int (*)(void *, double))call)(f->instance, t));
}

/* How many of the times are not after t. */
static size_t passed_by(const Course *c, double t) {
    size_t low = 0, high = c->n;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (c->t[middle] <= t)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Both know of the jumps up to time passed that they were made, and of all others that they were
 * not: at its time a jump has two values. */
static double value_of(const Course *c, double t, double passed) {
    size_t i = passed_by(c, c->held ? passed : fmax(t, passed));
    if (i == 0)
        return c->values[0];
    i--;
    const bool before_jump = !c->held && c->t[i] > passed && i > 0 && c->t[i] == c->t[i - 1];
    while (before_jump && i > 0 && c->t[i] == c->t[i - 1])
        i--;
    if (c->held || before_jump || i + 1 == c->n)
        return c->values[i];
    const double share = (c->t[i + 1] - t) / (c->t[i + 1] - c->t[i]); /* as cosim.Table has it */
    return share * c->values[i] + (1.0 - share) * c->values[i + 1];
}

static double next_jump(const Course *c, double passed) {
    for (size_t i = passed_by(c, passed); i < c->n; i++)
        if (i > 0 && (c->t[i] == c->t[i - 1] || (c->held && c->values[i] != c->values[i - 1])))
            return c->t[i];
    return INFINITY;
}

/* A continuous input at time t of the step: on its course, on the polynomial that the coupling
 * gave, on a straight line where both ends of the step are known, else held from the begin of the
 * step. */
static double input_at(const GeneralComponent *f, size_t i, double t) {
    const Integrator *in = f->integrator;
    const double s = t - in->begin;
    if (f->courses[i].n)
        return value_of(&f->courses[i], t, f->passed);
    if (f->follows)
        return f->after[i] + s * (f->rates[i] + s / 2.0 * f->rates[f->n_inputs + i]);
    const double share = f->input_ports[i].ahead ? fmin(1.0, s / (in->end - in->begin)) : 1.0;
    return (1.0 - share) * f->before[i] + share * f->after[i];
}

static fmi2Status set_moving_inputs(GeneralComponent *f, double t) {
    for (size_t i = 0; i < f->n_inputs; i++) {
        const Port *port = &f->input_ports[i];
        const Group *group = &f->inputs.groups[port->group];
        if (!group->discrete)
            store(group, port->place, input_at(f, i, t));
    }
    for (size_t i = 0; i < f->inputs.n; i++)
        if (!f->inputs.groups[i].discrete)
            TRY_STATUS(transfer(f, &f->inputs.groups[i]));
    return fmi2OK;
}

static fmi2Status set_point(GeneralComponent *f, double t, double *x) {
    TRY_STATUS(set_time(f, t));
    TRY_STATUS(f->n_states ? exchange(f, SET_STATES, x, f->n_states) : fmi2OK);
    return f->integrator->moving ? set_moving_inputs(f, t) : fmi2OK;
}

/* What CVode is given: 0 done, 1 try a smaller step, -1 give up. */
static int answer(GeneralComponent *f, fmi2Status status) {
    f->integrator->status = status;
    if (status == fmi2Discard) { /* it may yet come right */
        f->integrator->discarded = f->called;
        f->called = NULL;
    }
    return OK(status) ? 0 : status == fmi2Discard ? 1 : -1;
}

static int derivatives(double t, void *states, void *rates, void *component) {
    GeneralComponent *f = component;
    const Cvode *cvode = f->cvode;
    double *dx = cvode->N_VGetArrayPointer_Serial(rates);
    dx[0] = 0.0;
    fmi2Status status = set_point(f, f->start + t, cvode->N_VGetArrayPointer_Serial(states));
    if (OK(status) && f->n_states)
        status = exchange(f, GET_DERIVATIVES, dx, f->n_states);
    return answer(f, status);
}

static int indicators(double t, void *states, double *z, void *component) {
    GeneralComponent *f = component;
    fmi2Status status = set_point(f, f->start + t, f->cvode->N_VGetArrayPointer_Serial(states));
    if (OK(status))
        status = exchange(f, GET_INDICATORS, z, f->n_indicators);
    return answer(f, status);
}

static void store_message(int line, const char *function, const char *file, const char *message,
                          int code, void *component, void *context) {
    GeneralComponent *f = component;
    (void)line, (void)file, (void)code, (void)context;
    if (f->log.severity < fmi2Error) {
        f->log.severity = fmi2Error;
        snprintf(f->log.message, sizeof f->log.message, "%s: %s", function, message);
    }
}

static fmi2Status solver_failed(GeneralComponent *f) {
    const fmi2Status status = f->integrator->status;
    if (status > fmi2Discard)
        return status; /* the FMU is to blame; f->called says where */
    if (status == fmi2Discard) {
        f->called = f->integrator->discarded;
        return status;
    }
    f->called = "CVode";
    f->log.reason = SOLVER_FAILED;
    return (fmi2Status)SOLVER_FAILED;
}

/* Take over the FMU's states, which an event may have changed. */
static fmi2Status read_states(GeneralComponent *f) {
    Integrator *in = f->integrator;
    in->x[0] = in->atol[0] = 1.0;
    if (f->n_states) {
        TRY_STATUS(exchange(f, GET_STATES, in->x, f->n_states));
        TRY_STATUS(exchange(f, GET_NOMINALS, in->atol, f->n_states));
    }
    for (size_t i = 0; i < in->n; i++) {
        const double nominal = fabs(in->atol[i]);
        in->atol[i] = f->tolerance * (nominal > 0.0 && isfinite(nominal) ? nominal : 1.0);
    }
    return fmi2OK;
}

fmi2Status restart_exchange(GeneralComponent *f) {
    Integrator *in = f->integrator;
    TRY_STATUS(read_states(f));
    return f->cvode->CVodeReInit(in->memory, f->time - f->start, in->states) ? solver_failed(f)
                                                                             : fmi2OK;
}

static fmi2Status count(GeneralComponent *f, enum Call place, size_t *n) {
    AnyCall *call = calling(f, place);
    if (f->version == 2)
        return fmi2OK; /* the description says */
    return checked(f, place, ((int (*)(void *, size_t *))call)(f->instance, n));
}

void seek_jump(GeneralComponent *f) {
    f->next_jump = INFINITY;
    for (size_t i = 0; i < f->n_inputs; i++)
        f->next_jump = fmin(f->next_jump, next_jump(&f->courses[i], f->passed));
}

/* All jumps up to the present time are made. */
static void pass_jumps(GeneralComponent *f) {
    f->passed = f->time + f->near;
    seek_jump(f);
}

fmi2Status begin_exchange(GeneralComponent *f) {
    const Cvode *cvode = f->cvode;
    end_exchange(f);
    pass_jumps(f);
    Integrator *in = f->integrator = calloc(1, sizeof *in);
    TRY_STATUS(count(f, COUNT_STATES, &f->n_states));
    TRY_STATUS(count(f, COUNT_INDICATORS, &f->n_indicators));
    if (!in || cvode->SUNContext_Create(0, &in->context))
        return solver_failed(f);
    if (f->n_states > MOST_STATES || f->n_indicators > MOST_STATES) {
        return failed_by(f, f->n_states > MOST_STATES ? COUNT_STATES : COUNT_INDICATORS,
                         OUT_OF_MEMORY);
    }
    in->n = f->n_states ? f->n_states : 1;
    in->begin = f->time;
    cvode->SUNContext_ClearErrHandlers(in->context);
    cvode->SUNContext_PushErrHandler(in->context, store_message, f);
    in->states = cvode->N_VNew_Serial((int64_t)in->n, in->context);
    in->tolerances = cvode->N_VNew_Serial((int64_t)in->n, in->context);
    if (!in->states || !in->tolerances)
        return failed_by(f, GET_STATES, OUT_OF_MEMORY);
    in->x = cvode->N_VGetArrayPointer_Serial(in->states);
    in->atol = cvode->N_VGetArrayPointer_Serial(in->tolerances);
    TRY_STATUS(read_states(f));
    in->matrix = cvode->SUNDenseMatrix((int64_t)in->n, (int64_t)in->n, in->context);
    in->solver = cvode->SUNLinSol_Dense(in->states, in->matrix, in->context);
    void *memory = in->memory = cvode->CVodeCreate(CV_BDF, in->context);
    const bool failed = !in->matrix || !in->solver || !memory ||
                        cvode->CVodeInit(memory, derivatives, f->time - f->start, in->states) ||
                        cvode->CVodeSetUserData(memory, f) ||
                        cvode->CVodeSVtolerances(memory, f->tolerance, in->tolerances) ||
                        cvode->CVodeRootInit(memory, (int)f->n_indicators, indicators) ||
                        cvode->CVodeSetLinearSolver(memory, in->solver, in->matrix) ||
                        cvode->CVodeSetMaxNumSteps(memory, MAX_SOLVER_STEPS) ||
                        cvode->CVodeSetMaxStep(memory, LONGEST * (f->stop - f->start)) ||
                        cvode->CVodeSetNoInactiveRootWarn(memory);
    return failed ? solver_failed(f) : fmi2OK;
}

void end_exchange(GeneralComponent *f) {
    Integrator *in = f->integrator;
    const Cvode *cvode = f->cvode;
    if (!in)
        return;
    cvode->CVodeFree(&in->memory); /* as all of these, it takes NULL */
    cvode->SUNLinSolFree(in->solver);
    cvode->SUNMatDestroy(in->matrix);
    cvode->N_VDestroy_Serial(in->states);
    cvode->N_VDestroy_Serial(in->tolerances);
    cvode->SUNContext_Free(&in->context);
    free(in);
    f->integrator = NULL;
}

static fmi2Status completed_step(GeneralComponent *f, bool *event) {
    AnyCall *call = calling(f, COMPLETED_STEP);
    bool enter = false, terminate = false;
    int status = fmi2OK;
    if (!f->notes_steps)
        return fmi2OK;
    if (f->version == 2) {
        fmi2Boolean enter2 = fmi2False, terminate2 = fmi2False;
        status = (int)((fmi2CompletedIntegratorStepTYPE *)call)(f->instance, fmi2True, &enter2,
                                                                &terminate2);
        enter = enter2;
        terminate = terminate2;
    } else {
        status =
            (int)((fmi3CompletedIntegratorStepTYPE *)call)(f->instance, true, &enter, &terminate);
    }
    *event = *event || enter;
    TRY_STATUS(checked(f, COMPLETED_STEP, status));
    return terminate ? failed_by(f, COMPLETED_STEP, TERMINATED) : fmi2OK;
}

/* CVode may look beyond target, and is the more accurate for it, where nothing happens there: not
 * beyond a time event or a tick, and with inputs not beyond the time up to which they are known. */
static int set_stop(GeneralComponent *f, double target) {
    const double stop = f->n_inputs ? target : fmin(f->next_event, f->next_tick);
    return isfinite(stop) ? f->cvode->CVodeSetStopTime(f->integrator->memory, stop - f->start)
                          : f->cvode->CVodeClearStopTime(f->integrator->memory);
}

/* Integrate to target, or to the first event before it. */
static fmi2Status integrate(GeneralComponent *f, double target, bool *event) {
    Integrator *in = f->integrator;
    const double end = target - f->start;
    const bool there = target - f->time <= rounding_of(end);
    if (there || (f->n_states == 0 && f->n_indicators == 0)) {
        f->time = target;
        TRY_STATUS(set_point(f, target, in->x));
        return there ? fmi2OK : completed_step(f, event);
    }
    in->status = fmi2OK;
    if (set_stop(f, target))
        return solver_failed(f);
    double reached = 0.0;
    const int flag = f->cvode->CVode(in->memory, end, in->states, &reached, CV_NORMAL);
    if (flag < 0)
        return solver_failed(f);
    f->time = reached == end ? target : f->start + reached;
    *event = flag == CV_ROOT_RETURN;
    TRY_STATUS(set_point(f, f->time, in->x));
    return completed_step(f, event);
}

/* Whether a continuous input begins a step elsewhere than it ended the one before. A polynomial may
 * miss it by a rounding error. */
static bool leaps(const GeneralComponent *f, size_t i, double value) {
    const Integrator *in = f->integrator;
    const double h = in->end - in->begin, *rates = f->rates;
    const double size = fabs(value) + fabs(f->before[i]) + h * fabs(rates[i]) +
                        h * h * fabs(rates[f->n_inputs + i]);
    return f->follows ? fabs(value - f->before[i]) > ROUNDING * size : value != f->before[i];
}

/* Of the inputs that follow no course, at the begin of a step or at its end. A discrete one jumps
 * at the end where the value there is what is known. */
static fmi2Status take_inputs(GeneralComponent *f, bool at_end) {
    const Integrator *in = f->integrator;
    bool event = false, leap = false;
    for (size_t i = 0; i < f->n_inputs; i++) {
        const Port *port = &f->input_ports[i];
        const Group *group = &f->inputs.groups[port->group];
        if (f->courses[i].n || (group->discrete && (port->ahead != 0) != at_end))
            continue;
        const double value =
            group->discrete ? f->after[i] : input_at(f, i, at_end ? in->end : in->begin);
        event = event || is_event(group, f->before[i], value);
        leap = leap || (!group->discrete && !at_end && leaps(f, i, value));
        if (group->discrete || at_end)
            f->before[i] = value;
        store(group, port->place, value);
    }
    if (event)
        TRY_STATUS(handle_event(f, true));
    else if (leap)
        TRY_STATUS(set_moving_inputs(f, f->time));
    return event || leap ? restart_exchange(f) : fmi2OK;
}

static bool moves(const GeneralComponent *f, size_t i) {
    if (f->courses[i].n)
        return !f->courses[i].held;
    const bool changes = f->before[i] != f->after[i];
    return f->follows ? changes || f->rates[i] != 0.0 || f->rates[f->n_inputs + i] != 0.0
                      : f->input_ports[i].ahead && changes;
}

static bool inputs_move(const GeneralComponent *f) {
    for (size_t i = 0; i < f->n_inputs; i++)
        if (!f->inputs.groups[f->input_ports[i].group].discrete && moves(f, i))
            return true;
    return false;
}

/* Courses have reached a jump: an event with the values after it. */
static fmi2Status jump(GeneralComponent *f) {
    pass_jumps(f);
    for (size_t i = 0; i < f->n_inputs; i++) {
        const Port *port = &f->input_ports[i];
        if (f->courses[i].n) {
            store(&f->inputs.groups[port->group], port->place,
                  value_of(&f->courses[i], f->time, f->passed));
        }
    }
    return handle_event(f, true);
}

fmi2Status step_exchange(GeneralComponent *f, double t, double h) {
    Integrator *in = f->integrator;
    in->begin = t;
    in->end = t + h;
    TRY_STATUS(take_inputs(f, false));
    in->moving = inputs_move(f);
    for (int i = 0; f->time < in->end; i++) {
        const double next = fmin(fmin(f->next_event, f->next_tick), f->next_jump);
        bool event = false;
        if (i == MAX_EVENTS)
            return failed_by(f, UPDATE_DISCRETE_STATES, TOO_MANY_EVENTS);
        TRY_STATUS(
            integrate(f, next < in->end && !is_due(f, in->end, next) ? next : in->end, &event));
        const bool jumps = is_due(f, f->next_jump, f->time);
        if (event || jumps || is_due(f, fmin(f->next_event, f->next_tick), f->time)) {
            TRY_STATUS(jumps ? jump(f) : handle_event(f, false));
            TRY_STATUS(restart_exchange(f));
        }
    }
    in->moving = false;
    return take_inputs(f, true);
}
