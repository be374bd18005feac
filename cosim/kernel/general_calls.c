/* The calls of the general path on an FMU: what they are called, and what they answered. */
#include "general_path.h"

#define FMI2(place, fmi2, fmi3, interfaces) fmi2,
#define FMI3(place, fmi2, fmi3, interfaces) fmi3,
static const char *const NAMES[][N_CALLS] = {{GENERAL_CALLS(FMI2)}, {GENERAL_CALLS(FMI3)}};

#ifdef MARKED
AnyCall *calling(const GeneralComponent *f, enum Call place) {
    MARK_CALL(NAMES[f->version - 2][place]);
    return f->call[place];
}
#endif

/* A warning is checked here and OK for the kernel. */
fmi2Status noted(GeneralComponent *f, const char *call, int status) {
    restore_sums();
    if (status == fmi2OK)
        return fmi2OK;
    if (status == fmi2Warning) {
        note_warning(&f->log, call, f->time);
        return fmi2OK;
    }
    f->called = call;
    if (status == fmi2Fatal)
        f->instance = NULL;
    if ((unsigned)status > (f->version == 2 ? (unsigned)fmi2Pending : (unsigned)fmi3Fatal)) {
        f->log.unknown = status;
        f->log.reason = status = UNKNOWN_STATUS;
    }
    return (fmi2Status)status;
}

fmi2Status checked(GeneralComponent *f, enum Call place, int status) {
    return noted(f, NAMES[f->version - 2][place], status);
}

fmi2Status failed_by(GeneralComponent *f, enum Call place, int reason) {
    f->called = NAMES[f->version - 2][place];
    f->log.reason = reason;
    return (fmi2Status)reason;
}

fmi2Status simple_call(GeneralComponent *f, enum Call place) {
    return checked(f, place, ((int (*)(void *))calling(f, place))(f->instance));
}
