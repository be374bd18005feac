/* An FMU for the tests: x' = A x + B u + E, y = C x + D u + F, exact for inputs that are
 * polynomials of degree 2 in time. SIZE states, inputs and outputs. Names a[i,j] as in
 * linear_fmu.py. The exact step is the exponential of the system that has the inputs' derivatives
 * as states too. */
#include <fenv.h>
#include <fmi2Functions.h>
#include <fmi3Functions.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { N = 2, ORDERS = 3, M = N + N * ORDERS + 1 };
/* References: u x0 y, then the matrices row by row. */
enum { U, X0 = U + N, Y = X0 + N, A = Y + N, B = A + N * N, C = B + N * N, D = C + N * N };
enum { E = D + N * N, F = E + N, CUBIC = F + N, N_REALS };

typedef struct {
    double real[N_REALS];
    double x[N];
    double du[2][N]; /* first and second derivative of the inputs */
} Model;

static void multiply(const double *a, const double *b, double *c) {
    for (int i = 0; i < M; i++) {
        for (int j = 0; j < M; j++) {
            c[i * M + j] = 0.0;
            for (int k = 0; k < M; k++) {
                c[i * M + j] += a[i * M + k] * b[k * M + j];
            }
        }
    }
}

static void exponential(double *a) {
    double term[M * M], sum[M * M], product[M * M], norm = 0.0;
    int halvings = 0;
    for (int i = 0; i < M * M; i++) {
        norm += fabs(a[i]);
    }
    for (; norm > 0.5; norm /= 2.0) {
        halvings++;
    }
    for (int i = 0; i < M * M; i++) {
        a[i] = ldexp(a[i], -halvings);
        sum[i] = term[i] = i % (M + 1) == 0;
    }
    for (int k = 1; k < 16; k++) {
        multiply(term, a, product);
        for (int i = 0; i < M * M; i++) {
            term[i] = product[i] / k;
            sum[i] += term[i];
        }
    }
    for (; halvings > 0; halvings--) {
        multiply(sum, sum, product);
        memcpy(sum, product, sizeof sum);
    }
    memcpy(a, sum, sizeof sum);
}

static void step(Model *m, double h) {
    double z[M], a[M * M] = {0.0}, x[N];
    for (int i = 0; i < N; i++) {
        for (int j = 0; j < N; j++) {
            a[i * M + j] = h * m->real[A + i * N + j];
            a[i * M + N + j] = h * m->real[B + i * N + j];
        }
        a[i * M + M - 1] = h * m->real[E + i];
        a[(N + i) * M + 2 * N + i] = a[(2 * N + i) * M + 3 * N + i] = h;
        z[i] = m->x[i];
        z[N + i] = m->real[U + i];
        z[2 * N + i] = m->du[0][i];
        z[3 * N + i] = m->du[1][i];
    }
    z[M - 1] = 1.0;
    exponential(a);
    for (int i = 0; i < N; i++) {
        x[i] = 0.0;
        for (int j = 0; j < M; j++) {
            x[i] += a[i * M + j] * z[j];
        }
    }
    for (int i = 0; i < N; i++) {
        m->x[i] = x[i];
        m->real[U + i] += h * (m->du[0][i] + h / 2.0 * m->du[1][i]);
        m->du[0][i] += h * m->du[1][i];
    }
}

static double output(const Model *m, int i) {
    double y = m->real[F + i];
    for (int j = 0; j < N; j++) {
        const double u = m->real[U + j];
        y += m->real[C + i * N + j] * m->x[j] +
             m->real[D + i * N + j] * (u + m->real[CUBIC] * u * u * u);
    }
    return y;
}

static int set(Model *m, const unsigned r[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++) {
        m->real[r[i]] = v[i];
        if (r[i] >= U && r[i] < U + N) {
            m->du[0][r[i] - U] = m->du[1][r[i] - U] = 0.0;
        }
        if (r[i] >= X0 && r[i] < X0 + N) {
            m->x[r[i] - X0] = v[i];
        }
    }
    return 0;
}

static int get(const Model *m, const unsigned r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] >= Y && r[i] < Y + N ? output(m, (int)(r[i] - Y)) : m->real[r[i]];
    }
    return 0;
}

static int save(const Model *m, void **state) {
    *state = *state ? *state : malloc(sizeof *m);
    return *state ? memcpy(*state, m, sizeof *m), 0 : 3;
}

static int discard(void **state) {
    free(*state);
    *state = NULL;
    return 0;
}

/* FMI 2.0 */
fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible,
                              fmi2Boolean logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)callbacks, (void)visible;
    (void)logging;
    return calloc(1, sizeof(Model));
}
void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2Reset(fmi2Component c) { return memset(c, 0, sizeof(Model)), fmi2OK; }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real d,
                               fmi2Boolean e, fmi2Real f) {
    (void)c, (void)a, (void)b, (void)d, (void)e, (void)f;
    return fmi2OK;
}
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2Terminate(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n,
                       const fmi2Real v[]) {
    return (fmi2Status)set(c, r, n, v);
}
fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real v[]) {
    return (fmi2Status)get(c, r, n, v);
}
fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                       const fmi2Integer order[], const fmi2Real v[]) {
    for (size_t i = 0; i < n; i++) {
        ((Model *)c)->du[order[i] - 1][r[i] - U] = v[i];
    }
    return fmi2OK;
}
fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean final) {
    (void)t, (void) final;
    return step(c, h), fmi2OK;
}
fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s) { return (fmi2Status)save(c, s); }
fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s) {
    return memcpy(c, s, sizeof(Model)), fmi2OK;
}
fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) {
    return (void)c, (fmi2Status)discard(s);
}
fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate s, size_t *size) {
    (void)c, (void)s;
    return *size = sizeof(Model), fmi2OK;
}
fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate s, fmi2Byte room[], size_t size) {
    return (void)c, memcpy(room, s, size), fmi2OK;
}
fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte room[], size_t size,
                                   fmi2FMUstate *s) {
    return (void)size,
           fmi2GetFMUstate(c, s) == fmi2OK ? (memcpy(*s, room, sizeof(Model)), fmi2OK) : fmi2Error;
}

/* FMI 3.0 */
fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference required[], size_t n,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)events;
    (void)early, (void)required, (void)n, (void)environment, (void)log, (void)update;
    return calloc(1, sizeof(Model));
}
void fmi3FreeInstance(fmi3Instance c) { free(c); }
fmi3Status fmi3Reset(fmi3Instance c) { return memset(c, 0, sizeof(Model)), fmi3OK; }
fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b, fmi3Float64 d,
                                       fmi3Boolean e, fmi3Float64 f) {
    (void)c, (void)a, (void)b, (void)d, (void)e, (void)f;
    return fmi3OK;
}
fmi3Status fmi3ExitInitializationMode(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3Terminate(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n,
                          const fmi3Float64 v[], size_t nv) {
    return (void)nv, (fmi3Status)set(c, r, n, v);
}
fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference r[], size_t n, fmi3Float64 v[],
                          size_t nv) {
    return (void)nv, (fmi3Status)get(c, r, n, v);
}
fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean final,
                      fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                      fmi3Float64 *reached) {
    (void) final;
    *event = *terminate = *early = false;
    *reached = t + h;
    return step(c, h), fmi3OK;
}
fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *s) { return (fmi3Status)save(c, s); }
fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState s) {
    return memcpy(c, s, sizeof(Model)), fmi3OK;
}
fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *s) {
    return (void)c, (fmi3Status)discard(s);
}
fmi3Status fmi3SerializedFMUStateSize(fmi3Instance c, fmi3FMUState s, size_t *size) {
    return (fmi3Status)fmi2SerializedFMUstateSize(c, s, size);
}
fmi3Status fmi3SerializeFMUState(fmi3Instance c, fmi3FMUState s, fmi3Byte room[], size_t size) {
    return (void)c, memcpy(room, s, size), fmi3OK;
}
fmi3Status fmi3DeserializeFMUState(fmi3Instance c, const fmi3Byte room[], size_t size,
                                   fmi3FMUState *s) {
    return (fmi3Status)fmi2DeSerializeFMUstate(c, (const fmi2Byte *)room, size, s);
}

/* Model Exchange */
fmi2Status fmi2EnterEventMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return (void)c, fmi2OK; }
fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t) { return (void)c, (void)t, fmi2OK; }
fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    (void)c;
    return *info = (fmi2EventInfo){0}, fmi2OK;
}
fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    return memcpy(x, ((Model *)c)->x, n * sizeof *x), fmi2OK;
}
fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n) {
    return memcpy(((Model *)c)->x, x, n * sizeof *x), fmi2OK;
}
fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real dx[], size_t n) {
    const Model *m = c;
    for (size_t i = 0; i < n; i++) {
        dx[i] = m->real[E + i];
        for (size_t j = 0; j < N; j++) {
            dx[i] += m->real[A + i * N + j] * m->x[j] + m->real[B + i * N + j] * m->real[U + j];
        }
    }
#ifdef LEAVES_ROUNDING
    fesetround(FE_UPWARD);
#endif
    return fmi2OK;
}
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n) {
    return (void)c, (void)z, (void)n, fmi2OK;
}
fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n) {
    (void)c;
    for (size_t i = 0; i < n; i++) {
        x[i] = 1.0;
    }
    return fmi2OK;
}
fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)log;
    return calloc(1, sizeof(Model));
}
fmi3Status fmi3EnterEventMode(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance c) { return (void)c, fmi3OK; }
fmi3Status fmi3SetTime(fmi3Instance c, fmi3Float64 t) { return (void)c, (void)t, fmi3OK; }
fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate,
                                    fmi3Boolean *nominals, fmi3Boolean *states,
                                    fmi3Boolean *defined, fmi3Float64 *next) {
    (void)c, (void)next;
    return *again = *terminate = *nominals = *states = *defined = false, fmi3OK;
}
fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) {
    return (void)c, *n = N, fmi3OK;
}
fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) {
    return (void)c, *n = 0, fmi3OK;
}
fmi3Status fmi3GetContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) {
    return (fmi3Status)fmi2GetContinuousStates(c, x, n);
}
fmi3Status fmi3SetContinuousStates(fmi3Instance c, const fmi3Float64 x[], size_t n) {
    return (fmi3Status)fmi2SetContinuousStates(c, x, n);
}
fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance c, fmi3Float64 dx[], size_t n) {
    return (fmi3Status)fmi2GetDerivatives(c, dx, n);
}
fmi3Status fmi3GetEventIndicators(fmi3Instance c, fmi3Float64 z[], size_t n) {
    return (void)c, (void)z, (void)n, fmi3OK;
}
fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance c, fmi3Float64 x[], size_t n) {
    return (fmi3Status)fmi2GetNominalsOfContinuousStates(c, x, n);
}
fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no_set, fmi2Boolean *enter,
                                       fmi2Boolean *terminate) {
    (void)c, (void)no_set;
    return *enter = *terminate = fmi2False, fmi2OK;
}
fmi3Status fmi3CompletedIntegratorStep(fmi3Instance c, fmi3Boolean no_set, fmi3Boolean *enter,
                                       fmi3Boolean *terminate) {
    (void)c, (void)no_set;
    return *enter = *terminate = false, fmi3OK;
}
