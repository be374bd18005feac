/* The life of a container; its state is in state.c. */
#include "inside.h"
#include "library.h"
#include "steps.h"
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE = 2048, PATH = 4096 };

const char *container_name(const Container *x) { return x->name; }
const Logger *container_logger(const Container *x) { return &x->logger; }
double container_time(const Container *x) {
    return x->run.start + (double)x->run.done * x->run.step;
}

Status report(const Container *x, Status status, const char *format, ...) {
    char message[MESSAGE];
    va_list values;
    va_start(values, format);
    vsnprintf(message, sizeof message, format, values);
    va_end(values);
    if (x->logger.callback) {
        x->logger.tell(x, status, message);
    }
    return status;
}

Status part_failed(Container *x, int i, const char *call, int status) {
    const char *said = x->logs[i].message;
    x->phase = BROKEN;
    return report(x, ERROR, "%s: %s failed (status %d) at t = %.9g s%s%s", PARTS[i].name, call,
                  status, container_time(x), *said ? ": " : "", said);
}

/* The kernel's call did not pass. */
static Status failed(Container *x) {
    return part_failed(x, (int)x->run.failed, x->run.call, (int)x->run.status);
}

bool container_may(Container *x, int phases, const char *call) {
    if ((int)x->phase & phases) {
        return true;
    }
    report(x, ERROR, "%s cannot be called in this state", call);
    return false;
}

Status container_refuse(Container *x, const char *call) {
    return report(x, ERROR, "%s is not available: modelDescription.xml does not declare it", call);
}

static bool instantiate_part(Container *x, int i) {
    const Part *part = &PARTS[i];
    Component *c = &x->components[i];
    char path[PATH], resources[3 * PATH];
    const int n = snprintf(path, sizeof path, "%s/%s/resources", x->resources, part->folder);
    if (n < 0 || n >= PATH) {
        report(x, ERROR, "the path of the resources is too long: %s", x->resources);
        return false;
    }
    if (c->version == 2) {
        uri_of_path(path, resources, sizeof resources);
    } else {
        snprintf(resources, sizeof resources, "%s/", path);
    }
    instantiate(c, part->name, part->token, resources);
    if (!c->instance) {
        report(x, ERROR, "%s cannot be instantiated: %s", part->name, c->log->message);
    }
    return c->instance != NULL;
}

static bool load_part(Container *x, int i) {
    char path[PATH], reason[MESSAGE / 2];
    const Part *part = &PARTS[i];
    Component *c = &x->components[i];
    *c = part->wiring;
    c->log = &x->logs[i];
    c->gathered = x->gathered[i];
    snprintf(path, sizeof path, "%s/%s/binaries/%s/%s" SUFFIX, x->resources, part->folder,
             c->version == 2 ? FOLDER2 : FOLDER3, part->identifier);
    x->access[i].library = library_open(path, reason, sizeof reason);
    if (!x->access[i].library) {
        report(x, ERROR, "%s cannot be loaded: %s", part->name, reason);
        return false;
    }
    const char *missing = access_load(&x->access[i], c);
    if (missing) {
        report(x, ERROR, "%s: its binary lacks the function %s", part->name, missing);
        return false;
    }
    return instantiate_part(x, i);
}

/* All start values that the system gives, and those of the inputs. */
static Status start(Container *x) {
    memset(x->rows, 0, sizeof x->rows);
    x->run.done = 0;
    x->run.start = 0.0;
    x->stop_defined = false;
    x->phase = NEW;
    for (int i = 0; i < N_VARIABLES; i++) {
        if (VARIABLES[i].role == INPUT) {
            x->rows[VARIABLES[i].column] = VARIABLES[i].start;
        }
    }
    for (int i = 0; i < N_STARTS; i++) {
        const Start *s = &STARTS[i];
        const int status = access_set(&x->access[s->part], &x->components[s->part], s->type,
                                      s->reference, s->value);
        if (status > WARNING) {
            return part_failed(x, s->part, "setting a start value", status);
        }
    }
    return OK;
}

Container *container_new(const char *name, const char *token, const char *resources,
                         Logger logger) {
    Container *x = calloc(1, sizeof *x);
    if (!x) {
        return NULL;
    }
    x->logger = logger;
    snprintf(x->name, sizeof x->name, "%s", name ? name : "");
    x->run = (Run){
        .components = x->components,
        .n_components = N_PARTS,
        .jacobi = JACOBI,
        .n_steps = INT64_MAX,
        .step = STEP,
        .n_external = N_INPUTS,
        .rows = x->rows,
        .width = WIDTH,
        .record = x->rows, /* not NULL: the rows are a window */
    };
    bool alive = token && strcmp(token, TOKEN) == 0 && resources;
    if (!alive) {
        report(x, ERROR, "the token is %s, expected %s; or there is no resource location",
               token ? token : "missing", TOKEN);
    }
    if (alive) {
        path_of_uri(resources, x->resources, sizeof x->resources);
    }
    for (int i = 0; alive && i < N_PARTS; i++) {
        alive = load_part(x, i);
    }
    if (!alive || start(x) != OK) {
        container_free(x);
        return NULL;
    }
    return x;
}

void container_free(Container *x) {
    for (int i = 0; x && i < N_PARTS; i++) {
        release(&x->components[i]);
        if (x->access[i].library) {
            library_close(x->access[i].library);
        }
    }
    free(x);
}

Status container_reset(Container *x) {
    for (int i = 0; i < N_PARTS; i++) {
        Component *c = &x->components[i];
        c->log->severity = 0;
        c->log->message[0] = '\0';
        if (c->instance && !reset(&x->run, c)) {
            release(c);
        }
        if (!c->instance && !instantiate_part(x, i)) {
            x->phase = BROKEN;
            return ERROR;
        }
    }
    return start(x);
}

/* Carry outputs to the inputs that they feed, until nothing changes any more. */
static Status settle(Container *x) {
    double before[WIDTH];
    for (int sweep = 0; x->stale && sweep <= N_PARTS + 1; sweep++) {
        memcpy(before, x->rows, sizeof before);
        for (int i = 0; i < N_PARTS; i++) {
            Component *c = &x->components[i];
            memcpy(x->rows + WIDTH, x->rows, WIDTH * sizeof *x->rows);
            if (!set_inputs(&x->run, c, x->rows) ||
                !get_outputs(&x->run, c, c->n_outputs, x->rows)) {
                return failed(x);
            }
        }
        x->stale = memcmp(before, x->rows, sizeof before) != 0;
    }
    if (x->stale) {
        x->phase = BROKEN;
        return report(x, ERROR, "the initial values of the components do not settle");
    }
    return OK;
}

Status container_plan(Container *x, double start_time, bool stop_defined, double stop) {
    if (!isfinite(start_time)) {
        return report(x, ERROR, "the start time is not finite");
    }
    x->run.start = start_time;
    x->run.stop = stop;
    x->stop_defined = stop_defined;
    return OK;
}

static bool enter(Container *x, Component *c) {
    Run *run = &x->run;
    const bool stops = x->stop_defined;
    if (c->version == 3) {
        return passed(run, c, "fmi3EnterInitializationMode",
                      (int)c->call.fmi3.EnterInitializationMode(c->instance, false, 0.0, run->start,
                                                                stops, run->stop));
    }
    return passed(run, c, "fmi2SetupExperiment",
                  (int)c->call.fmi2.SetupExperiment(c->instance, fmi2False, 0.0, run->start, stops,
                                                    run->stop)) &&
           passed(run, c, "fmi2EnterInitializationMode",
                  (int)c->call.fmi2.EnterInitializationMode(c->instance));
}

Status container_enter_initialization(Container *x) {
    for (int i = 0; i < N_PARTS; i++) {
        Component *c = &x->components[i];
        if (!enter(x, c) || !get_outputs(&x->run, c, c->n_outputs, x->rows)) {
            return failed(x);
        }
    }
    x->phase = INITIALIZING;
    x->stale = true;
    return OK;
}

Status container_leave_initialization(Container *x) {
    const Status settled = settle(x);
    if (settled != OK) {
        return settled;
    }
    for (int i = 0; i < N_PARTS; i++) {
        Component *c = &x->components[i];
        if (!exit_initialization(&x->run, c)) {
            return failed(x);
        }
    }
    for (int i = 0; i < N_PARTS; i++) {
        Component *c = &x->components[i];
        if (!get_outputs(&x->run, c, c->n_outputs, x->rows)) {
            return failed(x);
        }
    }
    x->phase = STEPPING;
    return OK;
}

static Status check_finite(Container *x) {
    for (int i = 0; i < N_PARTS; i++) {
        const Component *c = &x->components[i];
        for (size_t k = 0; k < c->n_outputs; k++) {
            if (!isfinite(x->rows[c->column + (int64_t)k])) {
                return part_failed(x, i, "an output is not finite, so the step", ERROR);
            }
        }
    }
    return OK;
}

Status container_step(Container *x, double t, double h) {
    Run *run = &x->run;
    const double n = round(h / STEP), now = container_time(x);
    if (!(n >= 1.0 && fabs(n * STEP - h) <= 1e-6 * STEP)) {
        return report(x, ERROR,
                      "a communication step of %.9g s is not possible: expected a multiple of the"
                      " components' step, %.9g s",
                      h, STEP);
    }
    if (!(fabs(t - now) <= 1e-6 * STEP)) {
        return report(x, ERROR, "the communication point is %.9g s, expected %.9g s", t, now);
    }
    const int64_t last = run->done + (int64_t)n;
    while (run->done < last) {
        memcpy(x->rows + WIDTH, x->rows, N_INPUTS * sizeof *x->rows);
        run->block_start = run->done;
        if (!step_until(run, run->done + 1)) {
            return failed(x);
        }
        memcpy(x->rows, x->rows + WIDTH, WIDTH * sizeof *x->rows);
        if (check_finite(x) != OK) {
            return ERROR;
        }
    }
    return OK;
}

Status container_terminate(Container *x) {
    x->phase = ENDED;
    for (int i = 0; i < N_PARTS; i++) {
        if (!terminate(&x->run, &x->components[i])) {
            return failed(x);
        }
    }
    return OK;
}

static const Variable *find(Container *x, uint32_t reference, Type type) {
    if (reference >= N_VARIABLES) {
        report(x, ERROR, "value reference %lu does not exist; the last one is %d",
               (unsigned long)reference, N_VARIABLES - 1);
        return NULL;
    }
    if (VARIABLES[reference].type != type) {
        report(x, ERROR, "%s is of another type", VARIABLES[reference].name);
        return NULL;
    }
    return &VARIABLES[reference];
}

Status container_get(Container *x, uint32_t reference, Type type, double *value) {
    const Variable *v = find(x, reference, type);
    if (!v) {
        return ERROR;
    }
    if (v->role == TIME) {
        *value = container_time(x);
        return OK;
    }
    if (v->role == INPUT || v->role == OUTPUT) {
        if (x->phase == INITIALIZING && settle(x) != OK) {
            return ERROR;
        }
        *value = x->rows[v->column];
        return OK;
    }
    const int status =
        access_get(&x->access[v->part], &x->components[v->part], v->type, v->reference, value);
    return status > WARNING ? part_failed(x, v->part, v->name, status) : OK;
}

Status container_set(Container *x, uint32_t reference, Type type, double value) {
    const Variable *v = find(x, reference, type);
    if (!v) {
        return ERROR;
    }
    const bool early = x->phase & (NEW | INITIALIZING);
    if (v->role == TIME || v->role == OUTPUT || (v->role == PARAMETER && !early)) {
        return report(x, ERROR, "%s cannot be set%s", v->name,
                      v->role == PARAMETER ? " once the FMU is initialised" : "");
    }
    x->stale = true;
    if (v->role == INPUT) {
        x->rows[v->column] = value;
        return OK;
    }
    const int status =
        access_set(&x->access[v->part], &x->components[v->part], v->type, v->reference, value);
    if (status > WARNING) {
        const char *said = x->logs[v->part].message;
        return report(x, ERROR, "%s = %.9g was refused%s%s", v->name, value, *said ? ": " : "",
                      said);
    }
    return OK;
}
