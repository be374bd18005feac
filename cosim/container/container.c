/* Instances of the components, and their messages. */
#include "inside.h"
#include "library.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE = 2048, PATH = 4096 };

Status report(const Instance *x, Status status, const char *format, ...) {
    char message[MESSAGE];
    va_list values;
    va_start(values, format);
    vsnprintf(message, sizeof message, format, values);
    va_end(values);
    if (x->logger.callback)
        x->logger.emit(&x->logger, x->name, status, "logStatusError", message);
    return status;
}

Status part_failed(Instance *x, int i, const char *call, int status) {
    Log *log = x->components[i].log;
    const char *message = log->message;
    take_stray(log);
    x->phase = BROKEN;
    return report(x, ERROR, "%s: %s failed (status %d) at t = %.9g s%s%s", PARTS[i].name, call,
                  status, instance_time(x), *message ? ": " : "", message);
}

Status instance_require(Instance *x, int phases, const char *call) {
    return (int)x->phase & phases ? OK
                                  : report(x, ERROR, "%s cannot be called in this state", call);
}

Status instance_unavailable(Instance *x, const char *call) {
    return !x ? ERROR
              : report(x, ERROR, "%s is not available: modelDescription.xml does not declare it",
                       call);
}

Status instance_lacks(Instance *x, const char *call) {
    return report(x, ERROR, "%s: an argument is NULL", call);
}

Status instance_mismatch(Instance *x, size_t references, size_t values, const char *call) {
    return report(x, ERROR, "%s: %zu values for %zu scalar variables", call, values, references);
}

/* Errors only, and those always. */
Status instance_log(Instance *x, bool on, size_t count, const char *const categories[]) {
    return OK;
}

static bool instantiate_part(Instance *x, int i) {
    const Part *part = &PARTS[i];
    Component *c = &x->components[i];
    char path[PATH], resources[3 * PATH];
    const int n = snprintf(path, sizeof path, "%s/%s/resources", x->resources, part->folder);
    if (n < 0 || n >= PATH) {
        report(x, ERROR, "the path of the resources is too long: %s", x->resources);
        return false;
    }
    if (part->wiring.version == 2)
        uri_of_path(path, resources, sizeof resources);
    else
        snprintf(resources, sizeof resources, "%s/", path);
    instantiate(c, part->name, part->token, resources);
    if (!c->instance)
        report(x, ERROR, "%s cannot be instantiated: %s", part->name, c->log->message);
    return c->instance != NULL;
}

static bool load_part(Instance *x, int i) {
    PLAIN_HERE;
    char path[PATH], reason[MESSAGE / 2];
    const Part *part = &PARTS[i];
    Component *c = &x->components[i];
    *c = part->wiring;
    c->log = &x->logs[i];
    c->gathered = x->gathered[i];
    snprintf(path, sizeof path, "%s/%s/binaries/%s/%s" SUFFIX, x->resources, part->folder,
             part->wiring.version == 2 ? FOLDER2 : FOLDER3, part->identifier);
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
static Status start(Instance *x) {
    memset(x->rows, 0, sizeof x->rows);
    x->run.done = 0;
    x->run.answers = (Answers){0};
    x->run.start = 0.0;
    x->run.stop = INFINITY;
    x->phase = INSTANTIATED;
    for (int i = 0; i < N_VARIABLES; i++)
        if (VARIABLES[i].role == INPUT)
            x->rows[VARIABLES[i].column] = VARIABLES[i].start;
    for (int i = 0; i < N_STARTS; i++) {
        const Start *s = &STARTS[i];
        const int status = access_set(x, s->part, s->type, s->reference, s->value);
        if (status > WARNING)
            return part_failed(x, s->part, "setting a start value", status);
    }
    return OK;
}

Instance *instance_new(const char *name, const char *token, const char *resources,
                       bool model_exchange, Logger logger) {
    Instance *x = model_exchange ? NULL : calloc(1, sizeof *x);
    if (!x)
        return NULL;
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
        .used_again = true,
    };
    bool alive = token && strcmp(token, TOKEN) == 0 && resources;
    if (!alive) {
        report(x, ERROR, "the token is %s, expected %s; or there is no resource location",
               token ? token : "missing", TOKEN);
    }
    if (alive)
        path_of_uri(resources, x->resources, sizeof x->resources);
    for (int i = 0; alive && i < N_PARTS; i++)
        alive = load_part(x, i);
    if (!alive || start(x) != OK) {
        instance_free(x);
        return NULL;
    }
    return x;
}

void instance_free(Instance *x) {
    for (int i = 0; x && i < N_PARTS; i++) {
        release(&x->components[i]);
        if (x->access[i].library)
            library_close(x->access[i].library);
    }
    free(x);
}

Status instance_reset(Instance *x) {
    PLAIN_HERE;
    for (int i = 0; i < N_PARTS; i++) {
        Component *c = &x->components[i];
        clear_log(c->log);
        if (c->instance && !reset(&x->run, c))
            release(c);
        if (!c->instance && !instantiate_part(x, i)) {
            x->phase = BROKEN;
            return ERROR;
        }
    }
    return start(x);
}
