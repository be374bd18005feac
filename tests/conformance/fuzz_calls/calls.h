/* FMI 2.0 or FMI 3.0 (-DFMI=2, -DFMI=3) under one set of names. */
#ifndef CALLS_H
#define CALLS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

typedef void *Slave;
typedef void *State;

#if FMI == 2
#include <fmi2Functions.h>
typedef fmi2Boolean Truth;
#define CALL(name, ...) (int)fmi2##name(__VA_ARGS__)
#define EITHER(name2, name3, ...) (int)fmi2##name2(__VA_ARGS__)

static void hear(void *environment, const char *name, fmi2Status status, const char *category,
                 const char *format, ...) {
    (void)environment, (void)name, (void)status, (void)category, (void)format;
}

static inline Slave instantiate(const char *name, const char *token, bool exchange, bool log) {
    static const fmi2CallbackFunctions functions = {hear, calloc, free, NULL, NULL};
    const fmi2Type type = exchange ? fmi2ModelExchange : fmi2CoSimulation;
    return fmi2Instantiate(name, type, token, NULL, log ? &functions : NULL, 0, log);
}

static inline int enter_initialization(Slave c, double start) {
    (void)start;
    return (int)fmi2EnterInitializationMode(c);
}

/* answers: where what it says goes, or NULL */
static inline int step(Slave c, double t, double h, bool answers) {
    (void)answers;
    return (int)fmi2DoStep(c, t, h, fmi2True);
}

static inline int update(Slave c, bool answers, double *next) {
    fmi2EventInfo info = {0};
    const int status = (int)fmi2NewDiscreteStates(c, answers ? &info : NULL);
    *next = info.nextEventTime;
    return status;
}

static inline int completed(Slave c, bool answers) {
    fmi2Boolean a, b;
    return (int)fmi2CompletedIntegratorStep(c, 1, answers ? &a : NULL, &b);
}

#define ACCESS(verb, name2, name3, c, r, n, v, nv) (int)fmi2##verb##name2(c, r, n, v)
#else
#include <fmi3Functions.h>
typedef fmi3Boolean Truth;
#define CALL(name, ...) (int)fmi3##name(__VA_ARGS__)
#define EITHER(name2, name3, ...) (int)fmi3##name3(__VA_ARGS__)

static void hear(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category,
                 fmi3String message) {
    (void)environment, (void)status, (void)category, (void)message;
}

static inline Slave instantiate(const char *name, const char *token, bool exchange, bool log) {
    fmi3LogMessageCallback listener = log ? hear : NULL;
    if (exchange)
        return fmi3InstantiateModelExchange(name, token, NULL, 0, log, NULL, listener);
    return fmi3InstantiateCoSimulation(name, token, NULL, 0, log, 0, 0, NULL, 0, NULL, listener,
                                       NULL);
}

static inline int enter_initialization(Slave c, double start) {
    return (int)fmi3EnterInitializationMode(c, 0, 0.0, start, 0, 0.0);
}

static inline int step(Slave c, double t, double h, bool answers) {
    bool event, terminate, early;
    double last;
    return (int)fmi3DoStep(c, t, h, true, &event, answers ? &terminate : NULL, &early, &last);
}

static inline int update(Slave c, bool answers, double *next) {
    bool again, terminate, nominals, states, defined;
    *next = 0.0;
    return (int)fmi3UpdateDiscreteStates(c, &again, &terminate, &nominals, answers ? &states : NULL,
                                         &defined, next);
}

static inline int completed(Slave c, bool answers) {
    bool a, b;
    return (int)fmi3CompletedIntegratorStep(c, true, answers ? &a : NULL, &b);
}

#define ACCESS(verb, name2, name3, c, r, n, v, nv) (int)fmi3##verb##name3(c, r, n, v, nv)
#endif

#endif
