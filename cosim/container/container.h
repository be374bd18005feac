/* A whole system in one FMU: its components, which lie in the resources, and the kernel's loop.
 *
 * container.c knows the system from system.h, which tables.py writes; fmi2.c and fmi3.c give it the
 * names and types of a standard. Variables of the container are places in a row of the kernel
 * (inputs and outputs) or variables of a component, which are passed on. */
#ifndef COSIM_CONTAINER_H
#define COSIM_CONTAINER_H

#include "kernel.h"

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status; /* as in both standards */

/* Life cycle; a bit each, so that a call can name the phases it is legal in. */
enum Phase {
    NEW = 1,
    INITIALIZING = 2,
    STEPPING = 4,
    ENDED = 8,
    BROKEN = 16,
    ALIVE = NEW | INITIALIZING | STEPPING | ENDED,
    ANY = ALIVE | BROKEN,
};

typedef enum { REAL, INTEGER, BOOLEAN, N_TYPES } Type;

typedef enum {
    TIME,      /* of the container */
    INPUT,     /* a column of the row */
    OUTPUT,    /* likewise */
    PARAMETER, /* of a component, to be set until it is initialised */
    TUNABLE,   /* of a component, to be set at any time */
} Role;

typedef struct {
    const char *name;
    Type type;
    Role role;
    int part;           /* the component, of a parameter */
    uint32_t reference; /* in the component */
    int64_t column;     /* of an input or output */
    double start;       /* of an input or parameter */
} Variable;

/* A component: where it lies, and how the kernel finds its signals. */
typedef struct {
    const char *name, *token;
    const char *folder;     /* in the resources */
    const char *identifier; /* of the binary */
    Component wiring;
} Part;

typedef struct Container Container;

/* Passes a message on to the tool. */
typedef void Tell(const Container *container, Status status, const char *message);

typedef struct {
    Tell *tell;
    void (*callback)(void); /* NULL: the tool wants no messages */
    void *environment;
} Logger;

/* NULL, with a message, when the token is another, or a component cannot be loaded. */
Container *container_new(const char *name, const char *token, const char *resources, Logger logger);
void container_free(Container *container);
const char *container_name(const Container *container);
const Logger *container_logger(const Container *container);

/* Whether it is in one of the phases; else a message names the call. */
bool container_may(Container *container, int phases, const char *call);
Status container_refuse(Container *container, const char *call);

Status container_plan(Container *container, double start, bool stop_defined, double stop);
Status container_enter_initialization(Container *container);
Status container_leave_initialization(Container *container);
Status container_step(Container *container, double t, double h);
Status container_terminate(Container *container);
Status container_reset(Container *container);
double container_time(const Container *container);

Status container_get(Container *container, uint32_t reference, Type type, double *value);
Status container_set(Container *container, uint32_t reference, Type type, double value);

Status container_save(Container *container, void **state);
Status container_restore(Container *container, const void *state);
Status container_forget(Container *container, void **state);
Status container_size(Container *container, const void *state, size_t *size);
Status container_pack(Container *container, const void *state, uint8_t *bytes, size_t size);
Status container_unpack(Container *container, const uint8_t *bytes, size_t size, void **state);

#endif
