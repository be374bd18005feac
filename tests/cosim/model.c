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
enum { GIVE_NAN = 10, END, RETURN_EARLY, FAIL_TO_INITIALISE };

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

/* The cause comes before the error, as with Dymola. */
static int complain(const Model *m, int status, double t) {
    for (int i = 1; i <= 12; i++) {
        report(m, 0, "cause %g", i);
    }
    report(m, status, "broke at t = %g", t);
    return status;
}

static int step(Model *m, double t, double h) {
    if (t >= m->real[FAULT_TIME] && m->fault == GIVE_NAN) {
        m->real[Y] = NAN;
        m->real[K] = NAN;
    } else if (t >= m->real[FAULT_TIME] && m->fault > 1 && m->fault < GIVE_NAN) {
        return complain(m, m->fault, t);
    } else if (KIND == 1) {
        m->real[Y] += h * m->real[U];
    }
    return 0;
}

static int initialise(Model *m) {
    m->real[Y] = m->real[K];
    return m->fault == FAIL_TO_INITIALISE ? complain(m, 3, 0.0) : 0;
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

static int *integer(Model *m, unsigned reference) { return reference == N ? &m->n : &m->fault; }

static int set_integers(Model *m, const unsigned r[], size_t n, const int v[]) {
    for (size_t i = 0; i < n; i++) {
        *integer(m, r[i]) = v[i];
    }
    return 0;
}
fmi2Status fmi2SetInteger(fmi2Component c, const unsigned r[], size_t n, const fmi2Integer v[]) {
    return (fmi2Status)set_integers(c, r, n, v);
}
fmi3Status fmi3SetInt32(fmi3Instance c, const unsigned r[], size_t n, const fmi3Int32 v[],
                        size_t values) {
    return (fmi3Status)set_integers(c, r, n, v);
}
fmi2Status fmi2GetInteger(fmi2Component c, const unsigned r[], size_t n, fmi2Integer v[]) {
    for (size_t i = 0; i < n; i++) {
        v[i] = *integer(c, r[i]);
    }
    return fmi2OK;
}
fmi2Status fmi2SetBoolean(fmi2Component c, const unsigned r[], size_t n, const fmi2Boolean v[]) {
    return n ? (((Model *)c)->flag = v[0]), fmi2OK : fmi2OK;
}
fmi3Status fmi3SetBoolean(fmi3Instance c, const unsigned r[], size_t n, const fmi3Boolean v[],
                          size_t values) {
    return n ? (((Model *)c)->flag = v[0]), fmi3OK : fmi3OK;
}
fmi2Status fmi2GetBoolean(fmi2Component c, const unsigned r[], size_t n, fmi2Boolean v[]) {
    return n ? (v[0] = ((Model *)c)->flag), fmi2OK : fmi2OK;
}
fmi2Status fmi2SetString(fmi2Component c, const unsigned r[], size_t n, const fmi2String v[]) {
    snprintf(((Model *)c)->text, 32, "%s", n ? v[0] : "");
    return fmi2OK;
}
fmi3Status fmi3SetString(fmi3Instance c, const unsigned r[], size_t n, const fmi3String v[],
                         size_t values) {
    return (fmi3Status)fmi2SetString(c, r, n, v);
}
fmi2Status fmi2GetString(fmi2Component c, const unsigned r[], size_t n, fmi2String v[]) {
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] != SIGN ? ((Model *)c)->text : value(c, Y) > 0.0 ? "up" : "not \xc3\xbcp";
    }
    return fmi2OK;
}
fmi3Status fmi3GetString(fmi3Instance c, const unsigned r[], size_t n, fmi3String v[],
                         size_t values) {
    return (fmi3Status)fmi2GetString(c, r, n, v);
}
