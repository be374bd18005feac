#include "kernel.h"
#include "mark.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FMI2_NAME(call) "fmi2" #call " "
#define FMI3_NAME(call) "fmi3" #call " "
const char *fmi2_calls(void) { return FMI2_CALLS(FMI2_NAME); }
const char *fmi3_calls(void) { return FMI3_CALLS(FMI3_NAME); }

static bool graver(Log *log, int status) {
    status = (unsigned)status > fmi2Pending ? fmi2Pending : status; /* none is no less grave */
    if (!log || status <= log->severity) { /* an FMU may have lost where it belongs */
        return false;
    }
    log->severity = status;
    return true;
}

/* Whether a format has a %n, which no message needs: it writes into memory. */
static bool writes(const char *format) {
    for (const char *p = format; (p = strchr(p, '%')); p += *p != '\0') {
        p += 1 + strspn(p + 1, "#0- +\'*.123456789$hlLqjzt");
        if (*p == 'n') {
            return true;
        }
    }
    return false;
}

static void log_fmi2(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                     fmi2String category, fmi2String message, ...) {
    Log *log = environment;
    (void)name;
    if (message && writes(message)) {
        log_fmi3(log, (fmi3Status)status, category, message);
    } else if (message && graver(log, (int)status)) {
        va_list values;
        va_start(values, message);
        vsnprintf(log->message, sizeof log->message, message, values);
        va_end(values);
    }
}

void log_fmi3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
              fmi3String message) {
    Log *log = environment;
    (void)category;
    if (message && graver(log, (int)status)) {
        snprintf(log->message, sizeof log->message, "%s", message);
    }
}

void clear_log(Log *log) {
    log->severity = log->reason = log->unknown = 0;
    log->warnings = 0;
    log->message[0] = log->warning[0] = '\0';
}

void note_warning(Log *log, const char *call, double t) {
    if (log->warnings++ == 0) {
        log->warned = call;
        log->warned_at = t;
        if (log->severity <= fmi2Warning) {
            memcpy(log->warning, log->message, sizeof log->warning);
        }
    }
}

void instantiate(Component *c, const char *name, const char *token, const char *resources) {
    Log *log = c->log;
    MARK_FIRST(c);
    c->used = 0;
    clear_log(log);
    if (c->version == 2) {
        MARK(c, "fmi2Instantiate");
        log->callbacks = (fmi2CallbackFunctions){log_fmi2, calloc, free, NULL, log};
        c->instance = c->call.fmi2.Instantiate(name, fmi2CoSimulation, token, resources,
                                               &log->callbacks, fmi2False, fmi2False);
    } else {
        MARK(c, "fmi3InstantiateCoSimulation");
        c->instance = c->call.fmi3.InstantiateCoSimulation(
            name, token, resources, false, false, false, false, NULL, 0, log, log_fmi3, NULL);
    }
}

void release(Component *c) {
    if (c->instance) {
        if (c->version == 2) {
            MARK(c, "fmi2FreeInstance");
            c->call.fmi2.FreeInstance(c->instance);
        } else {
            MARK(c, "fmi3FreeInstance");
            c->call.fmi3.FreeInstance(c->instance);
        }
    }
    c->instance = NULL;
}
