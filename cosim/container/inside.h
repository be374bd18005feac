/* A whole system in one FMU: its components, in the resources, and the kernel's loop.
 *
 * The C files beside this one know the system from system.h, which tables.py writes; the faces give
 * them the names and types of a standard. Variables of the container are places in a row of the
 * kernel (inputs and outputs) or variables of a component, to which calls are passed on. */
#ifndef COSIM_INSIDE_H
#define COSIM_INSIDE_H

#include "calls.h"
#include "cvode.h"
#include "face.h"
#include "general_path.h"
#include "kernel.h"

enum { N_TYPES = STRING }; /* of values: reals, integers, Booleans */
enum { N_SOLVER = 5 };     /* libraries that CVode consists of */

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
    const GeneralComponent *general; /* NULL where the kernel's loop steps it as it is */
    bool coupled;                    /* its inputs come from other components */
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
    GeneralComponent general[N_PARTS];
    Cvode cvode;
    void *solver[N_SOLVER]; /* its libraries */
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
void access_load_values(Access *access, int version); /* those for values other than signals */

/* Let a component be on the general path, with the functions of its binary. Likewise. */
const char *general_load(Instance *x, int part);
void general_unload(Instance *x, int part);
/* Set a tunable parameter between two steps, by an event where it has events. */
int general_put(Instance *x, int part, void (*set)(void), uint32_t reference, void *value);

/* Let the errors that the solver of a coupled component makes in a run stay below the coupling's.
 */
void general_tighten(Instance *x, int part);

/* Model Exchange: load the solver from the resources. Reports why that fails. */
bool solver_load(Instance *x);
void solver_unload(Instance *x);

/* The version of FMI of a component's binary. */
static inline int version_of(int part) {
    return (int)(PARTS[part].general ? PARTS[part].general->version : PARTS[part].wiring.version);
}

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
