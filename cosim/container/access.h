/* What the kernel does not call on a component: values other than its signals, and its state. */
#ifndef COSIM_ACCESS_H
#define COSIM_ACCESS_H

#include "container.h"

typedef struct {
    void *library;
    void (*set[N_TYPES])(void), (*get[N_TYPES])(void);
    void (*save)(void), (*restore)(void), (*forget)(void);
    void (*size)(void), (*pack)(void), (*unpack)(void);
} Access;

/* Take all functions from the binary. Returns the name of one that is missing, or NULL. */
const char *access_load(Access *access, Component *c);

/* Set or get one value. Returns an FMI status. */
int access_set(const Access *access, const Component *c, Type type, uint32_t reference,
               double value);
int access_get(const Access *access, const Component *c, Type type, uint32_t reference,
               double *value);

/* The state, as in the standards. */
int access_save(const Access *access, const Component *c, void **state);
int access_restore(const Access *access, const Component *c, void *state);
int access_forget(const Access *access, const Component *c, void **state);
int access_size(const Access *access, const Component *c, void *state, size_t *size);
int access_pack(const Access *access, const Component *c, void *state, void *bytes, size_t size);
int access_unpack(const Access *access, const Component *c, const void *bytes, size_t size,
                  void **state);

#endif
