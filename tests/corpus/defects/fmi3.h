/* The functions that FMI 3.0 has in a shape of its own. */

const char *fmi3GetVersion(void) { return has("version") ? "3.1" : "3.0"; }

static Model *made(fmi3String name, fmi3String token, bool logging, void *environment,
                   fmi3LogMessageCallback log) {
    Model *m = make(name, token);
    if (m) {
        m->log = log;
        m->environment = environment;
        m->logging = logging;
    }
    return m;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String place,
                                          fmi3Boolean visible, fmi3Boolean logging,
                                          fmi3InstanceEnvironment environment,
                                          fmi3LogMessageCallback log) {
    (void)place, (void)visible;
    return made(name, token, logging, environment, log);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String place,
                                         fmi3Boolean visible, fmi3Boolean logging,
                                         fmi3Boolean events, fmi3Boolean early,
                                         const fmi3ValueReference wanted[], size_t n,
                                         fmi3InstanceEnvironment environment,
                                         fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update) {
    (void)place, (void)visible, (void)events, (void)early, (void)wanted, (void)n, (void)update;
    return made(name, token, logging, environment, log);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean a, fmi3Float64 b,
                                       fmi3Float64 start, fmi3Boolean d, fmi3Float64 e) {
    (void)a, (void)b, (void)d, (void)e;
    return enter(c, start);
}

/* Only w is an array. */
#define ACCESS(Name, type)                                                                         \
    fmi3Status fmi3Get##Name(fmi3Instance c, const fmi3ValueReference r[], size_t n, type v[],     \
                             size_t values) {                                                      \
        size_t place = 0;                                                                          \
        for (size_t k = 0; k < n; k++)                                                             \
            for (unsigned i = 0; i < (r[k] == W ? 3 : 1); i++) {                                   \
                double x;                                                                          \
                if (place == values || get(c, r[k] + i, &x) != OK)                                 \
                    return fmi3Error;                                                              \
                v[place++] = (type)x;                                                              \
            }                                                                                      \
        return fmi3OK;                                                                             \
    }                                                                                              \
    fmi3Status fmi3Set##Name(fmi3Instance c, const fmi3ValueReference r[], size_t n,               \
                             const type v[], size_t values) {                                      \
        size_t place = 0;                                                                          \
        for (size_t k = 0; k < n; k++)                                                             \
            for (unsigned i = 0; i < (r[k] == W ? 3 : 1); i++)                                     \
                if (place == values || set(c, r[k] + i, (double)v[place++]) != OK)                 \
                    return fmi3Error;                                                              \
        return fmi3OK;                                                                             \
    }

ACCESS(Float64, fmi3Float64)
ACCESS(Int32, fmi3Int32)
ACCESS(Int64, fmi3Int64)
ACCESS(UInt64, fmi3UInt64)

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference rows[], size_t m,
                                        const fmi3ValueReference columns[], size_t n,
                                        const fmi3Float64 seed[], size_t a, fmi3Float64 result[],
                                        size_t b) {
    (void)a, (void)b;
    for (size_t i = 0; i < m; i++) {
        result[i] = 0;
        for (size_t j = 0; j < n; j++)
            result[i] += slope(of(c), rows[i], columns[j]) * seed[j];
    }
    return fmi3OK;
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance c, const fmi3ValueReference rows[], size_t m,
                                    const fmi3ValueReference columns[], size_t n,
                                    const fmi3Float64 seed[], size_t a, fmi3Float64 result[],
                                    size_t b) {
    (void)a, (void)b;
    for (size_t j = 0; j < n; j++) {
        result[j] = 0;
        for (size_t i = 0; i < m; i++)
            result[j] += (has("adjoint") ? -1 : 1) * slope(of(c), rows[i], columns[j]) * seed[i];
    }
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n) {
    *n = has("states-count") ? 2 : 1;
    return c ? fmi3OK : fmi3Error;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n) {
    *n = 1;
    return c ? fmi3OK : fmi3Error;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *more, fmi3Boolean *end,
                                    fmi3Boolean *nominals, fmi3Boolean *values, fmi3Boolean *timed,
                                    fmi3Float64 *time) {
    *more = has("iterates");
    *end = *nominals = *values = *timed = false;
    *time = 0;
    return c ? fmi3OK : fmi3Error;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 h, fmi3Boolean no,
                      fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early, fmi3Float64 *last) {
    (void)no;
    *event = *end = *early = false;
    *last = time + h;
    if (has("early-return"))
        *early = true;
    return step(c, time, h);
}
