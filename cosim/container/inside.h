/* A whole system in one FMU: its components, in the resources, and the kernel's loop.
 *
 * The C files beside this one know the system from system.h, which tables.py writes; the faces give
 * them the names and types of a standard. Variables of the container are places in a row of the
 * kernel (inputs and outputs) or variables of a component, to which calls are passed on. */
#ifndef COSIM_INSIDE_H
#define COSIM_INSIDE_H

#include "calls.h"
#include "face.h"
#include "kernel.h"

enum { N_TYPES = STRING }; /* of values: reals, integers, Booleans */

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

/* A component: its files, and how the kernel finds its signals. */
typedef struct {
    const char *name, *token;
    const char *folder;     /* in the resources */
    const char *identifier; /* of the binary */
    Component wiring;
} Part;

/* Functions of a component that the kernel does not call: values other than its signals, and its
 * state. Those that the component does not have are NULL. */
typedef struct {
    void *library;
    void (*set[N_TYPES])(void), (*get[N_TYPES])(void);
    int (*save)(void *, void **), (*restore)(void *, void *), (*forget)(void *, void **);
    int (*size)(void *, void *, size_t *), (*pack)(void *, void *, void *, size_t);
    int (*unpack)(void *, const void *, size_t, void **);
} Access;

#include "system.h" /* generated: TOKEN, STEP, VARIES_STEP, PARTS, STARTS, VARIABLES and their numbers */

struct Instance {
    Run run;
    Component components[N_PARTS];
    Access access[N_PARTS];
    Log logs[N_PARTS];
    double gathered[N_PARTS][MOST_INPUTS];
    double rows[2 * WIDTH]; /* of the present and of the next point in time */
    Phase phase;
    bool stale; /* in initialisation: what was set has not reached the outputs */
    Logger logger;
    char name[256];
    char resources[3072];
};

/* Take all functions from the binary of a component. Returns the name of one that is missing, or
 * NULL. */
const char *access_load(Access *access, Component *c);

/* Set or get one value of a component. Returns an FMI status. */
int access_set(Instance *x, int part, Type type, uint32_t reference, double value);
int access_get(const Instance *x, int part, Type type, uint32_t reference, double *value);

/* Pass a message on; returns the status. */
Status report(const Instance *x, Status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* In initialisation: carry outputs to the inputs they are connected to, until nothing changes. */
Status settle(Instance *x);

/* A call on a component failed: no more steps. */
Status part_failed(Instance *x, int part, const char *call, int status);

#endif
