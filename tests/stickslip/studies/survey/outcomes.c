/* y = t; what else happens is told by the token. FMPy gives no environment, the master does. */
#include <fmi2Functions.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define SHOWN __attribute__((visibility("default")))
#define OK(name, ...)                                                                              \
    SHOWN fmi2Status name(__VA_ARGS__) { return fmi2OK; }
#pragma GCC diagnostic ignored "-Wunused-parameter"

static char token[64];
static double t, shift;
static int instances, here;

SHOWN fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                    fmi2String resources, const fmi2CallbackFunctions *callbacks,
                                    fmi2Boolean visible, fmi2Boolean logging) {
    strncpy(token, guid, sizeof token - 1);
    instances++;
    here = callbacks->componentEnvironment != NULL;
    shift = 0.0;
    if (strcmp(token, "second run differs") == 0)
        shift = instances;
    else if (!here)
        shift = strcmp(token, "near") == 0 ? 1e-6 : strcmp(token, "different") == 0 ? 1.0 : 0.0;
    return token;
}
SHOWN fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
    t = 0.0;
    return fmi2OK;
}
SHOWN void fmi2FreeInstance(fmi2Component c) {}
OK(fmi2Reset, fmi2Component c)
OK(fmi2SetupExperiment, fmi2Component c, fmi2Boolean a, double b, double d, fmi2Boolean e, double f)
OK(fmi2ExitInitializationMode, fmi2Component c)
OK(fmi2Terminate, fmi2Component c)
OK(fmi2SetReal, fmi2Component c, const unsigned r[], size_t n, const double v[])
SHOWN fmi2Status fmi2DoStep(fmi2Component c, double begin, double h, fmi2Boolean last) {
    const int dies = strcmp(token, "died") == 0 ||
                     strcmp(token, here ? "works in FMPy only" : "works here only") == 0;
    if (dies)
        abort();
    while (strcmp(token, "out of time") == 0)
        sleep(60);
    t = begin + h;
    return fmi2OK;
}
SHOWN fmi2Status fmi2GetReal(fmi2Component c, const unsigned r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++)
        v[i] = r[i] == 0 ? t + shift : 0.0;
    return fmi2OK;
}
