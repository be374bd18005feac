#include "arithmetic.h"
#include "inside.h"
#include "library.h"
#include <stdio.h>

typedef union {
    double real;
    int32_t integer; /* fmi2Boolean too */
    bool boolean;
} Value;

#define TAKE(version, name)                                                                        \
    c->call.fmi##version.name =                                                                    \
        (fmi##version##name##TYPE *)library_function(access->library, "fmi" #version #name);       \
    if (!c->call.fmi##version.name) {                                                              \
        return "fmi" #version #name;                                                               \
    }
#define TAKE2(name) TAKE(2, name)
#define TAKE3(name) TAKE(3, name)
#define TAKE_STATE(member, name3, name2)                                                           \
    access->member = (__typeof__(access->member))library_function(                                 \
        access->library, c->version == 3 ? "fmi3" name3 : "fmi2" name2);

static void load_values(Access *access, int version) {
    static const char *const types[2][N_TYPES] = {{"Real", "Integer", "Boolean"},
                                                  {"Float64", "Int32", "Boolean"}};
    for (int type = 0; type < N_TYPES; type++) {
        char name[32];
        snprintf(name, sizeof name, "fmi%dSet%s", version, types[version - 2][type]);
        access->set[type] = library_function(access->library, name);
        name[4] = 'G';
        access->get[type] = library_function(access->library, name);
    }
}

/* What an FMU has no use for may be missing from the rest. */
const char *access_load(Access *access, Component *c) {
    if (c->version == 2) {
        FMI2_CALLS(TAKE2)
    } else {
        FMI3_CALLS(TAKE3)
    }
    load_values(access, c->version);
    TAKE_STATE(save, "GetFMUState", "GetFMUstate")
    TAKE_STATE(restore, "SetFMUState", "SetFMUstate")
    TAKE_STATE(forget, "FreeFMUState", "FreeFMUstate")
    TAKE_STATE(size, "SerializedFMUStateSize", "SerializedFMUstateSize")
    TAKE_STATE(pack, "SerializeFMUState", "SerializeFMUstate")
    TAKE_STATE(unpack, "DeserializeFMUState", "DeSerializeFMUstate")
    return NULL;
}

static int pass(const Instance *x, int part, void (*function)(void), uint32_t reference,
                void *value) {
    typedef int Pass2(void *, const uint32_t *, size_t, void *);
    typedef int Pass3(void *, const uint32_t *, size_t, void *, size_t);
    void *instance = x->components[part].instance;
    if (!function || !instance)
        return ERROR;
    return x->components[part].version == 2
               ? ((Pass2 *)function)(instance, &reference, 1, value)
               : ((Pass3 *)function)(instance, &reference, 1, value, 1);
}

int access_set(Instance *x, int part, Type type, uint32_t reference, double value) {
    PLAIN_HERE;
    Value v = {.real = value};
    if (type == BOOLEAN && x->components[part].version == 3)
        v.boolean = value != 0.0;
    else if (type != REAL)
        v.integer = (int32_t)value;
    return pass(x, part, x->access[part].set[type], reference, &v);
}

int access_get(const Instance *x, int part, Type type, uint32_t reference, double *value) {
    PLAIN_HERE;
    Value v = {.real = 0.0};
    const int status = pass(x, part, x->access[part].get[type], reference, &v);
    const bool is_short = type == BOOLEAN && x->components[part].version == 3;
    *value = type == REAL ? v.real : is_short ? v.boolean : v.integer;
    return status;
}
