/* The functions that FMI 2.0 has in a shape of its own. */

const char *fmi2GetVersion(void) { return has("version") ? "2.1" : "2.0"; }
const char *fmi2GetTypesPlatform(void) { return has("platform") ? "custom" : "default"; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String token, fmi2String place,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging) {
    Model *m = make(name, token);
    (void)type, (void)place, (void)visible;
    if (m) {
        m->callbacks = functions;
        m->logging = logging;
        if (has("callbacks"))
            functions->freeMemory(functions->allocateMemory(1, 8));
    }
    return m;
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean a, fmi2Real b, fmi2Real start,
                               fmi2Boolean d, fmi2Real e) {
    (void)a, (void)b, (void)d, (void)e;
    of(c)->v[TIME] = start;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return enter(c, of(c)->v[TIME]); }

#define ACCESS(Name, type)                                                                         \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2ValueReference r[], size_t n, type v[]) {  \
        for (size_t k = 0; k < n; k++) {                                                           \
            double x;                                                                              \
            if (get(c, r[k], &x) != OK)                                                            \
                return fmi2Error;                                                                  \
            v[k] = (type)x;                                                                        \
        }                                                                                          \
        return fmi2OK;                                                                             \
    }                                                                                              \
    fmi2Status fmi2Set##Name(fmi2Component c, const fmi2ValueReference r[], size_t n,              \
                             const type v[]) {                                                     \
        for (size_t k = 0; k < n; k++)                                                             \
            if (set(c, r[k], (double)v[k]) != OK)                                                  \
                return fmi2Error;                                                                  \
        return fmi2OK;                                                                             \
    }

ACCESS(Real, fmi2Real)
ACCESS(Integer, fmi2Integer)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference rows[], size_t m,
                                        const fmi2ValueReference columns[], size_t n,
                                        const fmi2Real seed[], fmi2Real result[]) {
    for (size_t i = 0; i < m; i++) {
        result[i] = 0;
        for (size_t j = 0; j < n; j++)
            result[i] += slope(of(c), rows[i], columns[j]) * seed[j];
    }
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info) {
    *info = (fmi2EventInfo){.newDiscreteStatesNeeded = has("iterates")};
    return c ? fmi2OK : fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real h, fmi2Boolean no) {
    (void)no;
    return step(c, time, h);
}
