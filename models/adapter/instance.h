/* One instance of the model, without a word of FMI: values, life cycle, checks, messages.
 *
 * All variables lie in one array of doubles, in value-reference order: time, inputs, states, modes,
 * derivatives, event indicators, outputs, memory, then the parameters (reals, integers, booleans).
 * Integers and booleans are whole numbers in it, so getters and setters need no switch.
 */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "face.h"
#include "table.h" /* generated: COUNT, INPUTS_AT ... */

typedef struct {
    const char *name;
    Type type;
    int settable; /* phases in which it may be set */
    double minimum, maximum, nominal;
} Variable;

extern const Variable VARIABLES[COUNT]; /* generated; the place is the value reference */

/* What differs between FMUs of one model. It is compiled by itself, so that the compiler cannot use
 * its values elsewhere: an exporter writes others into the library, behind the marker. */
typedef struct {
    char marker[START_MARKER_SIZE], token[START_TOKEN_SIZE];
    double values[COUNT];
} Start;

extern const Start START;

typedef struct {
    Phase phase;
    bool stale; /* outputs lag behind inputs, parameters or state */
    double values[COUNT];
} Snapshot;

typedef struct Saved Saved; /* a snapshot that the tool has */

struct Instance {
    Snapshot now;        /* all that save and restore touch */
    Saved *saved;        /* the latest; they form a list, so that others can be told from them */
    bool model_exchange; /* a tool's solver has it; else it steps by itself */
    Logger logger;
    char name[]; /* with the 0 */
};

static inline bool is_finite(double value) { return value - value == 0.0; }

/* Bring the outputs up to date before they are read; in Model Exchange the derivatives as well. */
void instance_refresh(Instance *instance);

/* Bring the modes to the present values; returns whether that set continuous states. */
bool instance_switch(Instance *instance);

/* OK when a time is finite; it is then the instance's. */
Status instance_set_time(Instance *instance, double time);

void instance_forget_all(Instance *instance);

#ifdef __GNUC__
__attribute__((format(printf, 4, 5)))
#endif
Status instance_report(Instance *instance, Status status, const char *category, const char *format,
                       ...);

#endif
