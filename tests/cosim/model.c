/* One small FMU for the tests, FMI 2.0 and FMI 3.0 in one library. KIND 0: y = k u; KIND 1: y' = u,
 * y(0) = k. */
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if KIND == 0
#define TOKEN "gain"
#else
#define TOKEN "integrator"
#endif

enum { U, Y, K, FAULT_TIME, SUM, N_REALS };
enum { FAULT = N_REALS, N, FLAG, TEXT, SIGN };
enum { GIVE_NAN = 10, END, RETURN_EARLY };

typedef struct {
    double real[N_REALS];
    int fault, n;
    bool flag;
    char text[32];
    const fmi2CallbackFunctions *callbacks;
    fmi3LogMessageCallback log;
    fmi3InstanceEnvironment environment;
} Model;

static void start(Model *m) {
    const double reals[N_REALS] = {0.0, 0.0, 1.0, 1e9, 0.0};
    memcpy(m->real, reals, sizeof reals);
    m->fault = 0;
    m->n = 0;
    m->flag = false;
    m->text[0] = '\0';
}

static double value(const Model *m, unsigned reference) {
    if (reference == Y && KIND == 0) {
        return m->real[K] * m->real[U];
    }
    if (reference == SUM) {
        return m->n + 10 * m->flag + 100 * (double)strlen(m->text);
    }
    return m->real[reference];
}

static void report(const Model *m, int status, const char *format, double number) {
    char message[64];
    if (m->callbacks) {
        m->callbacks->logger(m->callbacks->componentEnvironment, "model", (fmi2Status)status,
                             "error", format, number);
    } else {
        snprintf(message, sizeof message, format, number);
        m->log(m->environment, (fmi3Status)status, "error", message);
    }
}

static int step(Model *m, double t, double h) {
    if (t >= m->real[FAULT_TIME] && m->fault == GIVE_NAN) {
        m->real[Y] = NAN;
        m->real[K] = NAN;
    } else if (t >= m->real[FAULT_TIME] && m->fault > 1 && m->fault < GIVE_NAN) {
        report(m, 0, "cause %g", 1.0); /* before the error, as with Dymola */
        report(m, m->fault, "broke at t = %g", t);
        return m->fault;
    } else if (KIND == 1) {
        m->real[Y] += h * m->real[U];
    }
    return 0;
}

static int initialise(Model *m) {
    m->real[Y] = m->real[K];
    return 0;
}

static int set(Model *m, const unsigned r[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= N_REALS) {
            return 3;
        }
        m->real[r[i]] = v[i];
    }
    return 0;
}

static int get(const Model *m, const unsigned r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= N_REALS) {
            return 3;
        }
        v[i] = value(m, r[i]);
    }
    return 0;
}

static Model *create(const char *token, const fmi2CallbackFunctions *callbacks,
                     fmi3LogMessageCallback log, void *environment) {
    Model *m = calloc(1, sizeof *m);
    if (!m || strcmp(token, TOKEN) != 0) {
        free(m);
        return NULL;
    }
    m->callbacks = callbacks;
    m->log = log;
    m->environment = environment;
    start(m);
    return m;
}

static bool due(const Model *m, double t, int fault) {
    return t >= m->real[FAULT_TIME] && m->fault == fault;
}

#define MAKE create(token, callbacks, log, environment)
#define ENTER initialise(m)
/* The event must not matter: event mode is not used. */
#define STEP                                                                                       \
    (*event = true, *terminate = due(m, t, END), *early = due(m, t, RETURN_EARLY),                 \
     *reached = *early ? t : t + h, step(m, t, h))
#include "fmu.h"

#define EACH(prefix, function, type, tail, statement)                                              \
    prefix##Status prefix##function(void *c, const unsigned r[], size_t n, type v[] tail) {        \
        Model *m = c;                                                                              \
        for (size_t i = 0; i < n; i++) {                                                           \
            statement;                                                                             \
        }                                                                                          \
        return prefix##OK;                                                                         \
    }
#define ALONE
#define COUNTED , size_t values
#define INTEGER (*(r[i] == N ? &m->n : &m->fault))
#define SIGN_OR_TEXT (r[i] != SIGN ? m->text : value(m, Y) > 0.0 ? "up" : "not \xc3\xbcp")
#define TAKE_TEXT snprintf(m->text, sizeof m->text, "%s", v[i])
EACH(fmi2, SetInteger, const fmi2Integer, ALONE, INTEGER = v[i])
EACH(fmi3, SetInt32, const fmi3Int32, COUNTED, INTEGER = v[i])
EACH(fmi2, GetInteger, fmi2Integer, ALONE, v[i] = INTEGER)
EACH(fmi2, SetBoolean, const fmi2Boolean, ALONE, m->flag = v[i])
EACH(fmi3, SetBoolean, const fmi3Boolean, COUNTED, m->flag = v[i])
EACH(fmi2, GetBoolean, fmi2Boolean, ALONE, v[i] = m->flag)
EACH(fmi2, SetString, const fmi2String, ALONE, TAKE_TEXT)
EACH(fmi3, SetString, const fmi3String, COUNTED, TAKE_TEXT)
EACH(fmi2, GetString, fmi2String, ALONE, v[i] = SIGN_OR_TEXT)
EACH(fmi3, GetString, fmi3String, COUNTED, v[i] = SIGN_OR_TEXT)
