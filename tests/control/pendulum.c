/* A driven pendulum for Model Exchange, FMI 2.0 and FMI 3.0, with its derivatives in closed form:
 *
 *   d theta/dt = omega,  d omega/dt = -k sin(theta) - c omega |omega| + torque
 *   x = sin(theta),  power = torque omega
 */
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

enum { THETA, OMEGA, TORQUE, K, DRAG, X, POWER, D_THETA, D_OMEGA, COUNT };

static void evaluate(double v[COUNT]) {
    v[X] = sin(v[THETA]);
    v[POWER] = v[TORQUE] * v[OMEGA];
    v[D_THETA] = v[OMEGA];
    v[D_OMEGA] = -v[K] * sin(v[THETA]) - v[DRAG] * v[OMEGA] * fabs(v[OMEGA]) + v[TORQUE];
}

static double derivative(const double v[COUNT], unsigned unknown, unsigned known) {
    if (unknown == X)
        return known == THETA ? cos(v[THETA]) : 0.0;
    if (unknown == POWER)
        return known == TORQUE ? v[OMEGA] : known == OMEGA ? v[TORQUE] : 0.0;
    if (unknown == D_THETA)
        return known == OMEGA ? 1.0 : 0.0;
    if (known == TORQUE)
        return 1.0;
    return known == OMEGA ? -2.0 * v[DRAG] * fabs(v[OMEGA]) : -v[K] * cos(v[THETA]);
}

static void *instantiate(void) {
    double *v = calloc(COUNT, sizeof *v);
    if (v)
        v[K] = 9.81;
    return v;
}

static int get(double v[COUNT], const unsigned r[], size_t n, double values[]) {
    evaluate(v);
    for (size_t i = 0; i < n; i++)
        values[i] = v[r[i]];
    return 0;
}

static int set(double v[COUNT], const unsigned r[], size_t n, const double values[]) {
    for (size_t i = 0; i < n; i++)
        v[r[i]] = values[i];
    return 0;
}

static int rates(double v[COUNT], double dx[2]) {
    evaluate(v);
    dx[0] = v[D_THETA], dx[1] = v[D_OMEGA];
    return 0;
}

static int vary(const double v[COUNT], const unsigned unknown[], size_t n, const unsigned known[],
                size_t m, const double seed[], double sensitivity[]) {
    for (size_t i = 0; i < n; i++) {
        sensitivity[i] = 0.0;
        for (size_t k = 0; k < m; k++)
            sensitivity[i] += derivative(v, unknown[i], known[k]) * seed[k];
    }
    return 0;
}

static const unsigned STATES[] = {THETA, OMEGA};

/* FMI 2.0 */
#define STATUS2 FMI2_Export fmi2Status
FMI2_Export fmi2Component fmi2Instantiate(fmi2String n, fmi2Type t, fmi2String g, fmi2String r,
                                          const fmi2CallbackFunctions *f, fmi2Boolean v,
                                          fmi2Boolean l) {
    return instantiate();
}
FMI2_Export void fmi2FreeInstance(fmi2Component c) { free(c); }
STATUS2 fmi2SetupExperiment(fmi2Component c, fmi2Boolean d, fmi2Real tol, fmi2Real start,
                            fmi2Boolean e, fmi2Real stop) {
    return fmi2OK;
}
STATUS2 fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
STATUS2 fmi2ExitInitializationMode(fmi2Component c) { return fmi2OK; }
STATUS2 fmi2EnterEventMode(fmi2Component c) { return fmi2OK; }
STATUS2 fmi2EnterContinuousTimeMode(fmi2Component c) { return fmi2OK; }
STATUS2 fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    *info = (fmi2EventInfo){0};
    return fmi2OK;
}
STATUS2 fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean n, fmi2Boolean *event,
                                    fmi2Boolean *end) {
    *event = *end = fmi2False;
    return fmi2OK;
}
STATUS2 fmi2SetTime(fmi2Component c, fmi2Real t) { return fmi2OK; }
STATUS2 fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    return (fmi2Status)get(c, r, n, v);
}
STATUS2 fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real v[]) {
    return (fmi2Status)set(c, r, n, v);
}
STATUS2 fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    return (fmi2Status)get(c, STATES, n, x);
}
STATUS2 fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    return (fmi2Status)set(c, STATES, n, x);
}
STATUS2 fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    return (fmi2Status)rates(c, dx);
}
STATUS2 fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference u[], size_t n,
                                     const fmi2ValueReference k[], size_t m, const fmi2Real seed[],
                                     fmi2Real s[]) {
    return (fmi2Status)vary(c, u, n, k, m, seed, s);
}

/* FMI 3.0 */
#define STATUS3 FMI3_Export fmi3Status
FMI3_Export fmi3Instance fmi3InstantiateModelExchange(fmi3String n, fmi3String t, fmi3String r,
                                                      fmi3Boolean v, fmi3Boolean l,
                                                      fmi3InstanceEnvironment e,
                                                      fmi3LogMessageCallback f) {
    return instantiate();
}
FMI3_Export void fmi3FreeInstance(fmi3Instance c) { free(c); }
STATUS3 fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean d, fmi3Float64 tol,
                                    fmi3Float64 start, fmi3Boolean e, fmi3Float64 stop) {
    return fmi3OK;
}
STATUS3 fmi3ExitInitializationMode(fmi3Instance c) { return fmi3OK; }
STATUS3 fmi3EnterEventMode(fmi3Instance c) { return fmi3OK; }
STATUS3 fmi3EnterContinuousTimeMode(fmi3Instance c) { return fmi3OK; }
STATUS3 fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *end,
                                 fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *defined,
                                 fmi3Float64 *next) {
    *again = *end = *nominals = *values = *defined = false;
    return fmi3OK;
}
STATUS3 fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean n, fmi3Boolean *event,
                                    fmi3Boolean *end) {
    *event = *end = false;
    return fmi3OK;
}
STATUS3 fmi3SetTime(fmi3Instance c, fmi3Float64 t) { return fmi3OK; }
STATUS3 fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Float64 v[],
                       size_t m) {
    return (fmi3Status)get(c, r, n, v);
}
STATUS3 fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                       const fmi3Float64 v[], size_t m) {
    return (fmi3Status)set(c, r, n, v);
}
STATUS3 fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) {
    return (fmi3Status)get(c, STATES, n, x);
}
STATUS3 fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) {
    return (fmi3Status)set(c, STATES, n, x);
}
STATUS3 fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 dx[], size_t n) {
    return (fmi3Status)rates(c, dx);
}
STATUS3 fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference u[], size_t n,
                                     const fmi3ValueReference k[], size_t m,
                                     const fmi3Float64 seed[], size_t o, fmi3Float64 s[],
                                     size_t p) {
    return (fmi3Status)vary(c, u, n, k, m, seed, s);
}
