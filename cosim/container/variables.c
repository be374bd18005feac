/* Values of variables, from a row of the kernel or from a component. */
#include "inside.h"

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
        take_stray(&x->logs[v->part]);
        return report(x, ERROR, "%s = %.9g was refused%s%s", v->name, value, *said ? ": " : "",
                      said);
    }
    return OK;
}
