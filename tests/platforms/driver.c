/* Loads the FMU beside it, runs it through the table in run.h and writes all that it shows, as raw
 * doubles, to standard output. The table is generated: FMI, LIBRARY, TOKEN, STEP, STEPS, inputs,
 * switches, what to show. On Windows it needs the system alone, as the FMU does. */
#include <stddef.h>
#include <stdint.h>

#include "run.h"

#ifdef _WIN32
#define SYSTEM(type) __declspec(dllimport) type __stdcall
SYSTEM(void *) LoadLibraryA(const char *name);
SYSTEM(void *) GetProcAddress(void *library, const char *name);
SYSTEM(void *) GetStdHandle(unsigned long which);
SYSTEM(int)
WriteFile(void *file, const void *bytes, unsigned long size, unsigned long *written, void *);
SYSTEM(void) ExitProcess(unsigned status);
#define ENTRY void wWinMainCRTStartup(void)
static void *load(void) { return LoadLibraryA(LIBRARY); }
static void *find(void *library, const char *name) { return GetProcAddress(library, name); }
static void show(double value) {
    unsigned long written;
    WriteFile(GetStdHandle((unsigned long)-11), &value, sizeof value, &written, NULL);
}
static void end(int status) { ExitProcess((unsigned)status); }
#else
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#define ENTRY int main(void)
static void *load(void) { return dlopen("./" LIBRARY, RTLD_NOW); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
static void show(double value) { fwrite(&value, sizeof value, 1, stdout); }
static void end(int status) { exit(status); }
#endif

#if FMI == 2
#include <fmi2Functions.h>
#define CALL(Name, ...) require(((fmi2##Name##TYPE *)find(library, "fmi2" #Name))(__VA_ARGS__))
typedef fmi2Boolean Boolean;
typedef fmi2Component Instance;
#define REAL(access, ...) CALL(access##Real, __VA_ARGS__)
#define SLOPE(...) CALL(GetDirectionalDerivative, __VA_ARGS__)
#else
#include <fmi3Functions.h>
#define CALL(Name, ...) require(((fmi3##Name##TYPE *)find(library, "fmi3" #Name))(__VA_ARGS__))
typedef fmi3Boolean Boolean;
typedef fmi3Instance Instance;
#define REAL(access, ...) CALL(access##Float64, __VA_ARGS__, 1)
#define SLOPE(i, of, n_of, by, n_by, seed, value)                                                  \
    CALL(GetDirectionalDerivative, i, of, n_of, by, n_by, seed, n_by, value, n_of)
#endif

static void require(int status) {
    if (status)
        end(2);
}

#if FMI == 2
static void log_nothing(void *e, fmi2String n, fmi2Status s, fmi2String c, fmi2String m, ...) {
    (void)e, (void)n, (void)s, (void)c, (void)m;
}

static Instance begin(void *library) {
    static const fmi2CallbackFunctions callbacks = {log_nothing, NULL, NULL, NULL, NULL};
    fmi2InstantiateTYPE *instantiate = (fmi2InstantiateTYPE *)find(library, "fmi2Instantiate");
    Instance i = instantiate("driver", fmi2CoSimulation, TOKEN, "", &callbacks, 0, 0);
    for (int k = 0; i && k < SWITCHES; k++) {
        const Boolean on = 1;
        CALL(SetBoolean, i, &SWITCH[k], 1, &on);
    }
    CALL(SetupExperiment, i, 0, 0.0, 0.0, 0, 0.0);
    CALL(EnterInitializationMode, i);
    CALL(ExitInitializationMode, i);
    return i;
}

static void step(void *library, Instance i, double t) { CALL(DoStep, i, t, STEP, 1); }
#else
static Instance begin(void *library) {
    fmi3InstantiateCoSimulationTYPE *instantiate =
        (fmi3InstantiateCoSimulationTYPE *)find(library, "fmi3InstantiateCoSimulation");
    Instance i = instantiate("driver", TOKEN, "", 0, 0, 0, 0, NULL, 0, NULL, NULL, NULL);
    for (int k = 0; i && k < SWITCHES; k++) {
        const Boolean on = 1;
        CALL(SetBoolean, i, &SWITCH[k], 1, &on, 1);
    }
    CALL(EnterInitializationMode, i, 0, 0.0, 0.0, 0, 0.0);
    CALL(ExitInitializationMode, i);
    return i;
}

static void step(void *library, Instance i, double t) {
    bool event, terminate, early;
    double last;
    CALL(DoStep, i, t, STEP, true, &event, &terminate, &early, &last);
}
#endif

ENTRY {
    void *library = load();
    if (!library)
        end(3);
    Instance i = begin(library);
    if (!i)
        end(4);
    for (int n = 0; n < STEPS; n++) {
        for (int k = 0; k < INPUTS; k++)
            REAL(Set, i, &INPUT[k], 1, &FED[n][k]);
        step(library, i, n * STEP);
        for (int k = 0; k < SHOWN; k++) {
            double value;
            REAL(Get, i, &SHOW[k], 1, &value);
            show(value);
        }
        for (int k = 0; k < UNKNOWNS * KNOWNS; k++) {
            const double seed = 1.0;
            double value;
            SLOPE(i, &UNKNOWN[k / (KNOWNS + !KNOWNS)], 1, &KNOWN[k % (KNOWNS + !KNOWNS)], 1, &seed,
                  &value);
            show(value);
        }
    }
    end(0);
}
