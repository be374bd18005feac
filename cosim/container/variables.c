/* Values of variables, from a row of the kernel or from a component. */
#include "inside.h"

Status instance_check(Instance *x, uint32_t reference, Type type, const char *call) {
    if (reference >= N_VARIABLES) {
        return report(x, ERROR, "%s: value reference %lu does not exist; the last one is %d", call,
                      (unsigned long)reference, N_VARIABLES - 1);
    }
    if (VARIABLES[reference].type != type)
        return report(x, ERROR, "%s: %s is of another type", call, VARIABLES[reference].name);
    return OK;
}

Status instance_get(Instance *x, uint32_t reference, Type type, double *value, const char *call) {
    if (instance_check(x, reference, type, call) != OK)
        return ERROR;
    const Variable *v = &VARIABLES[reference];
    if (v->role == TIME) {
        *value = instance_time(x);
        return OK;
    }
    if (v->role == INPUT || v->role == OUTPUT) {
        if (x->phase == INITIALIZATION && settle(x) != OK)
            return ERROR;
        *value = x->rows[v->column];
        return OK;
    }
    const int status = access_get(x, v->part, v->type, v->reference, value);
    return status > WARNING ? part_failed(x, v->part, v->name, status) : OK;
}

Status instance_accepts(Instance *x, uint32_t reference, Type type, double value,
                        const char *call) {
    if (instance_check(x, reference, type, call) != OK)
        return ERROR;
    const Variable *v = &VARIABLES[reference];
    const bool early = x->phase & (INSTANTIATED | INITIALIZATION);
    if (v->role == TIME || v->role == OUTPUT || (v->role == PARAMETER && !early)) {
        return report(x, ERROR, "%s cannot be set%s", v->name,
                      v->role == PARAMETER ? " once the FMU is initialised" : "");
    }
    return OK;
}

Status instance_put(Instance *x, uint32_t reference, double value) {
    const Variable *v = &VARIABLES[reference];
    x->stale = true;
    if (v->role == INPUT) {
        x->rows[v->column] = value;
        return OK;
    }
    const int status = access_set(x, v->part, v->type, v->reference, value);
    if (status > WARNING) {
        Log *log = x->components[v->part].log;
        const char *message = log->message;
        take_stray(log);
        return report(x, ERROR, "%s = %.9g was refused%s%s", v->name, value, *message ? ": " : "",
                      message);
    }
    return OK;
}
