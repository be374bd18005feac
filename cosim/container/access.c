#include "access.h"
#include "arithmetic.h"
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

/* What an FMU has no use for may be missing from the rest. */
const char *access_load(Access *access, Component *c) {
    static const char *const types[2][N_TYPES] = {{"Real", "Integer", "Boolean"},
                                                  {"Float64", "Int32", "Boolean"}};
    static const char *const states[2][6] = {
        {"fmi2GetFMUstate", "fmi2SetFMUstate", "fmi2FreeFMUstate", "fmi2SerializedFMUstateSize",
         "fmi2SerializeFMUstate", "fmi2DeSerializeFMUstate"},
        {"fmi3GetFMUState", "fmi3SetFMUState", "fmi3FreeFMUState", "fmi3SerializedFMUStateSize",
         "fmi3SerializeFMUState", "fmi3DeserializeFMUState"}};
    void (**places[])(void) = {&access->save, &access->restore, &access->forget,
                               &access->size, &access->pack,    &access->unpack};
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
    for (int i = 0; i < 6; i++) {
        *places[i] = library_function(access->library, states[version][i]);
    }
    return NULL;
}

static int pass(void (*function)(void), const Component *c, uint32_t reference, void *value) {
    if (!function) {
        return ERROR;
    }
    if (c->version == 2) {
        return ((int (*)(void *, const uint32_t *, size_t, void *))function)(c->instance,
                                                                             &reference, 1, value);
    }
    return ((int (*)(void *, const uint32_t *, size_t, void *, size_t))function)(
        c->instance, &reference, 1, value, 1);
}

int access_set(const Access *access, const Component *c, Type type, uint32_t reference,
               double value) {
    PLAIN_HERE;
    Value v = {.real = value};
    if (type == BOOLEAN && c->version == 3) {
        v.boolean = value != 0.0;
    } else if (type != REAL) {
        v.integer = (int32_t)value;
    }
    return pass(access->set[type], c, reference, &v);
}

int access_get(const Access *access, const Component *c, Type type, uint32_t reference,
               double *value) {
    PLAIN_HERE;
    Value v = {.real = 0.0};
    const int status = pass(access->get[type], c, reference, &v);
    *value = type == REAL ? v.real : type == BOOLEAN && c->version == 3 ? v.boolean : v.integer;
    return status;
}

int access_save(const Access *access, const Component *c, void **state) {
    PLAIN_HERE;
    return !access->save ? ERROR : ((int (*)(void *, void **))access->save)(c->instance, state);
}

int access_restore(const Access *access, const Component *c, void *state) {
    PLAIN_HERE;
    return !access->restore ? ERROR
                            : ((int (*)(void *, void *))access->restore)(c->instance, state);
}

int access_forget(const Access *access, const Component *c, void **state) {
    PLAIN_HERE;
    return !access->forget ? ERROR : ((int (*)(void *, void **))access->forget)(c->instance, state);
}

int access_size(const Access *access, const Component *c, void *state, size_t *size) {
    PLAIN_HERE;
    return !access->size
               ? ERROR
               : ((int (*)(void *, void *, size_t *))access->size)(c->instance, state, size);
}

int access_pack(const Access *access, const Component *c, void *state, void *bytes, size_t size) {
    PLAIN_HERE;
    return !access->pack ? ERROR
                         : ((int (*)(void *, void *, void *, size_t))access->pack)(
                               c->instance, state, bytes, size);
}

int access_unpack(const Access *access, const Component *c, const void *bytes, size_t size,
                  void **state) {
    PLAIN_HERE;
    return !access->unpack ? ERROR
                           : ((int (*)(void *, const void *, size_t, void **))access->unpack)(
                                 c->instance, bytes, size, state);
}
