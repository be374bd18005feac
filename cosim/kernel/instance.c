#include "arithmetic.h"
#include "kernel.h"
#include "mark.h"
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What an FMU passes to the logger as its environment may be anything, so what it is given is a
 * place in this table: it can be recognised without being followed. */
enum { MOST_LOGS = 1 << 16 };
enum { N_LAST = 10, LENGTH_OF_LAST = sizeof(((Log *)NULL)->last) / N_LAST };
static _Atomic(Log *) logs[MOST_LOGS];

static void *register_log(Log *log) {
    static atomic_size_t next;
    for (size_t tries = 0; tries < MOST_LOGS; tries++) {
        _Atomic(Log *) *place = &logs[atomic_fetch_add(&next, 1) % MOST_LOGS];
        Log *free_place = NULL;
        if (atomic_compare_exchange_strong(place, &free_place, log))
            return place;
    }
    return NULL; /* its messages are taken for strays */
}

static void unregister_log(Log *log) {
    _Atomic(Log *) *place = log->callbacks.componentEnvironment;
    if (place)
        atomic_store(place, NULL);
    log->callbacks.componentEnvironment = NULL;
}

/* NULL where it is not a place in the table, or belongs to an instance that is freed. */
static Log *registered(const void *environment) {
    const uintptr_t offset = (uintptr_t)environment - (uintptr_t)logs;
    if (offset >= sizeof logs || offset % sizeof *logs != 0)
        return NULL;
    return atomic_load(&logs[offset / sizeof *logs]);
}

/* A message with another environment belongs to the call that this thread is in: it is kept until
 * that call returns a status, or until the next step. */
static _Thread_local struct {
    Log log;
    double t; /* s, when it came */
    const double *clock;
} stray;

static void forget_stray(void) {
    stray.log.severity = 0;
    stray.log.n_last = 0;
}

void keep_time(const double *clock) {
    forget_stray();
    stray.clock = clock;
}

static bool is_due(void) { return !stray.clock || *stray.clock == stray.t; }

static Log *log_of(const void *environment) {
    Log *log = registered(environment);
    if (log)
        return log;
    if (!is_due()) {
        forget_stray();
        stray.t = *stray.clock;
    }
    return &stray.log;
}

static const char *last_of(const Log *log, int64_t i) {
    return log->last + i % N_LAST * LENGTH_OF_LAST;
}

static void note_last(Log *log, const char *message) {
    snprintf((char *)last_of(log, log->n_last++), LENGTH_OF_LAST, "%s", message);
}

void take_stray(Log *log) {
    const int64_t n = stray.log.n_last;
    for (int64_t i = n > N_LAST ? n - N_LAST : 0; is_due() && i < n; i++)
        note_last(log, last_of(&stray.log, i));
    if (stray.log.severity > log->severity && is_due()) {
        log->severity = stray.log.severity;
        memcpy(log->message, stray.log.message, sizeof log->message);
    }
    forget_stray();
}

static void keep_message(Log *log, int status, const char *message) {
    /* An unknown status is as severe as any. */
    const int severity = (unsigned)status > fmi2Pending ? fmi2Pending : status;
    note_last(log, message);
    if (severity > log->severity) {
        log->severity = severity;
        snprintf(log->message, sizeof log->message, "%s", message);
    }
}

/* Whether a format has a %n, which no message needs: it writes into memory. */
static bool writes(const char *format) {
    for (const char *p = format; (p = strchr(p, '%')); p += *p != '\0') {
        p += 1 + strspn(p + 1, "#0- +\'*.123456789$hlLqjzt");
        if (*p == 'n')
            return true;
    }
    return false;
}

static void log_fmi2(fmi2ComponentEnvironment environment, fmi2String name, fmi2Status status,
                     fmi2String category, fmi2String message, ...) {
    Log *log = log_of(environment);
    (void)name;
    if (message && writes(message)) {
        log_fmi3(environment, (fmi3Status)status, category, message);
    } else if (message) {
        char text[sizeof log->message];
        va_list values;
        va_start(values, message);
        vsnprintf(text, sizeof text, message, values);
        va_end(values);
        keep_message(log, (int)status, text);
    }
}

void log_fmi3(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
              fmi3String message) {
    Log *log = log_of(environment);
    (void)category;
    if (message)
        keep_message(log, (int)status, message);
}

void clear_log(Log *log) {
    log->severity = log->reason = log->unknown = 0;
    log->warnings = log->n_last = 0;
    log->message[0] = log->warning[0] = '\0';
    forget_stray();
}

void note_warning(Log *log, const char *call, double t) {
    take_stray(log);
    if (log->warnings++ == 0) {
        log->warned = call;
        log->warned_at = t;
        if (log->severity <= fmi2Warning)
            memcpy(log->warning, log->message, sizeof log->warning);
    }
}

void instantiate(Component *c, const char *name, const char *token, const char *resources) {
    PLAIN_HERE;
    Log *log = c->log;
    MARK_FIRST(c);
    c->used = 0;
    clear_log(log);
    void *environment = log->callbacks.componentEnvironment;
    if (!environment)
        environment = register_log(log);
    log->callbacks = (fmi2CallbackFunctions){log_fmi2, calloc, free, NULL, environment};
    if (c->version == 2) {
        MARK(c, "fmi2Instantiate");
        c->instance = c->call.fmi2.Instantiate(name, fmi2CoSimulation, token, resources,
                                               &log->callbacks, fmi2False, fmi2False);
    } else {
        MARK(c, "fmi3InstantiateCoSimulation");
        c->instance =
            c->call.fmi3.InstantiateCoSimulation(name, token, resources, false, false, false, false,
                                                 NULL, 0, environment, log_fmi3, NULL);
    }
    take_stray(log);
}

void release(Component *c) {
    PLAIN_HERE;
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
    if (c->log)
        unregister_log(c->log);
}
