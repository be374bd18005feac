/* Initialises and steps the components. */
#include "inside.h"
#include "steps.h"
#include <float.h>
#include <math.h>
#include <string.h>

double instance_time(const Instance *x) { return x->run.start + (double)x->run.done * x->run.step; }

/* The kernel's call did not pass. */
static Status failed(Instance *x) {
    return part_failed(x, (int)x->run.failed, x->run.call, (int)x->run.status);
}

/* Carry outputs to the inputs they are connected to, until nothing changes any more. */
Status settle(Instance *x) {
    PLAIN_HERE;
    double before[WIDTH];
    for (int sweep = 0; x->stale && sweep <= N_PARTS + 1; sweep++) {
        memcpy(before, x->rows, sizeof before);
        for (int i = 0; i < N_PARTS; i++) {
            Component *c = &x->components[i];
            memcpy(x->rows + WIDTH, x->rows, WIDTH * sizeof *x->rows);
            if (!set_inputs(&x->run, c, x->rows) || !get_outputs(&x->run, c, c->n_outputs, x->rows))
                return failed(x);
        }
        x->stale = memcmp(before, x->rows, sizeof before) != 0;
    }
    if (x->stale) {
        x->phase = BROKEN;
        return report(x, ERROR, "the initial values of the components do not settle");
    }
    return OK;
}

Status instance_set_up(Instance *x, double start_time, bool stop_defined, double stop) {
    if (!isfinite(start_time))
        return report(x, ERROR, "the start time is not finite");
    x->run.start = start_time;
    x->run.stop = stop_defined ? stop : INFINITY;
    return OK;
}

Status instance_enter_initialization(Instance *x) {
    PLAIN_HERE;
    for (int i = 0; i < N_PARTS; i++) {
        Component *c = &x->components[i];
        if (!enter_initialization(&x->run, c) || !get_outputs(&x->run, c, c->n_outputs, x->rows))
            return failed(x);
    }
    x->phase = INITIALIZATION;
    x->stale = true;
    return OK;
}

Status instance_exit_initialization(Instance *x) {
    PLAIN_HERE;
    const Status settled = settle(x);
    if (settled != OK)
        return settled;
    for (int i = 0; i < N_PARTS; i++) {
        Component *c = &x->components[i];
        if (!exit_initialization(&x->run, c))
            return failed(x);
    }
    for (int i = 0; i < N_PARTS; i++) {
        Component *c = &x->components[i];
        if (!get_outputs(&x->run, c, c->n_outputs, x->rows))
            return failed(x);
    }
    x->phase = STEPPING;
    return OK;
}

static Status check_finite(Instance *x) {
    for (int i = 0; i < N_PARTS; i++) {
        const Component *c = &x->components[i];
        for (size_t k = 0; k < c->n_outputs; k++)
            if (!isfinite(x->rows[c->column + (int64_t)k]))
                return part_failed(x, i, "an output is not finite, so the step", ERROR);
    }
    return OK;
}

static Status step_to(Instance *x, int64_t last) {
    Run *run = &x->run;
    while (run->done < last) {
        memcpy(x->rows + WIDTH, x->rows, N_INPUTS * sizeof *x->rows);
        run->block_start = run->done;
        if (!step_until(run, run->done + 1))
            return failed(x);
        memcpy(x->rows, x->rows + WIDTH, WIDTH * sizeof *x->rows);
        if (check_finite(x) != OK)
            return ERROR;
    }
    return OK;
}

/* The rest of a communication step, shorter than a step; steps are counted from its end. */
static Status step_short(Instance *x, double now, double rest) {
    Run *run = &x->run;
    run->start = now;
    run->done = 0;
    run->step = rest;
    const Status status = step_to(x, 1);
    run->step = STEP;
    if (status == OK) {
        run->start = now + rest;
        run->done = 0;
    }
    return status;
}

Status instance_step(Instance *x, double t, double h) {
    PLAIN_HERE;
    Run *run = &x->run;
    const double now = instance_time(x);
    const double near = 1e-6 * STEP + 2.0 * DBL_EPSILON * (fabs(now) + h); /* with rounding */
    const double n = floor((h + near) / STEP), rest = h - n * STEP;
    if (!(h > near && n < 0x1p53 && (VARIES_STEP || rest <= near))) {
        return report(x, ERROR,
                      "a communication step of %.9g s is not possible: expected a %s%.9g s", h,
                      VARIES_STEP ? "step above 0, such as that of the components, "
                                  : "multiple of the components' step, which not all of them can "
                                    "vary: ",
                      STEP);
    }
    if (!(fabs(t - now) <= near))
        return report(x, ERROR, "the communication point is %.9g s, expected %.9g s", t, now);
    const int64_t last = run->done + (int64_t)n;
    keep_time(&run->t);
    Status status = step_to(x, last);
    if (status == OK && rest > near)
        status = step_short(x, instance_time(x), t + h - instance_time(x));
    keep_time(NULL);
    return status;
}

Status instance_terminate(Instance *x) {
    PLAIN_HERE;
    x->phase = ENDED;
    for (int i = 0; i < N_PARTS; i++)
        if (!terminate(&x->run, &x->components[i]))
            return failed(x);
    return OK;
}
