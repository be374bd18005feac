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

/* What an FMU has no use for may be missing from the rest. */
const char *access_load(Access *access, Component *c) {
    static const char *const types[2][N_TYPES] = {{"Real", "Integer", "Boolean"},
                                                  {"Float64", "Int32", "Boolean"}};
    const int version = c->version - 2;
    if (c->version == 2) {
        FMI2_CALLS(TAKE2)
    } else {
        FMI3_CALLS(TAKE3)
    }
    for (int type = 0; type < N_TYPES; type++) {
        char name[32];
        snprintf(name, sizeof name, "fmi%dSet%s", c->version, types[version][type]);
        access->set[type] = library_function(access->library, name);
        name[4] = 'G';
        access->get[type] = library_function(access->library, name);
    }
    TAKE_STATE(save, "GetFMUState", "GetFMUstate")
    TAKE_STATE(restore, "SetFMUState", "SetFMUstate")
    TAKE_STATE(forget, "FreeFMUState", "FreeFMUstate")
    TAKE_STATE(size, "SerializedFMUStateSize", "SerializedFMUstateSize")
    TAKE_STATE(pack, "SerializeFMUState", "SerializeFMUstate")
    TAKE_STATE(unpack, "DeserializeFMUState", "DeSerializeFMUstate")
    return NULL;
}

static int pass(void (*function)(void), const Component *c, uint32_t reference, void *value) {
    typedef int Pass2(void *, const uint32_t *, size_t, void *);
    typedef int Pass3(void *, const uint32_t *, size_t, void *, size_t);
    if (!function) {
        return ERROR;
    }
    return c->version == 2 ? ((Pass2 *)function)(c->instance, &reference, 1, value)
                           : ((Pass3 *)function)(c->instance, &reference, 1, value, 1);
}

int access_set(const Instance *x, int part, Type type, uint32_t reference, double value) {
    PLAIN_HERE;
    const Component *c = &x->components[part];
    Value v = {.real = value};
    if (type == BOOLEAN && c->version == 3) {
        v.boolean = value != 0.0;
    } else if (type != REAL) {
        v.integer = (int32_t)value;
    }
    return pass(x->access[part].set[type], c, reference, &v);
}

int access_get(const Instance *x, int part, Type type, uint32_t reference, double *value) {
    PLAIN_HERE;
    const Component *c = &x->components[part];
    Value v = {.real = 0.0};
    const int status = pass(x->access[part].get[type], c, reference, &v);
    *value = type == REAL ? v.real : type == BOOLEAN && c->version == 3 ? v.boolean : v.integer;
    return status;
}
