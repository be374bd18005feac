/* A whole system in one FMU: its components, which lie in the resources, and the kernel's loop.
 *
 * container.c knows the system from system.h, which tables.py writes; fmi2.c and fmi3.c give it the
 * names and types of a standard. Variables of the container are places in a row of the kernel
 * (inputs and outputs) or variables of a component, which are passed on. */
#ifndef COSIM_CONTAINER_H
#define COSIM_CONTAINER_H

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

/* A component: where it lies, and how the kernel finds its signals. */
typedef struct {
    const char *name, *token;
    const char *folder;     /* in the resources */
    const char *identifier; /* of the binary */
    Component wiring;
} Part;

#endif
