/* One instance of the model, without a word of FMI: values, life cycle, checks, messages.
 *
 * All variables lie in one array of doubles, in value-reference order: time, inputs, states,
 * outputs, memory, then the parameters (reals, integers, booleans). Integers and booleans are
 * whole numbers in it, so getters and setters need no switch.
 */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "table.h" /* generated: COUNT, INPUTS_AT ..., MODEL_NAME, MODEL_TOKEN */

/* The numbers that both FMI 2.0 and FMI 3.0 give these. */
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;

/* Life cycle; a bit each, so that a call can name the phases it is legal in. */
typedef enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEPPING = 4,
    TERMINATED = 8,
    FAILED = 16,
    EVENT = 32, /* these two in Model Exchange, in place of STEPPING */
    CONTINUOUS = 64,
} Phase;

/* A derivative is a real that is calculated when it is asked for. */
typedef enum { REAL, INTEGER, BOOLEAN, STRING, DERIVATIVE } Type;

typedef struct {
    const char *name;
    Type type;
    int settable; /* phases in which it may be set */
    double start, minimum, maximum, nominal;
} Variable;

extern const Variable VARIABLES[COUNT]; /* generated; the place is the value reference */

/* Where messages go: emit translates for the callback that the tool gave. */
typedef struct Logger {
    void (*emit)(const struct Logger *logger, const char *name, Status status, const char *category,
                 const char *message);
    void (*callback)(void); /* NULL: the tool wants no messages */
    void *environment;
    bool events; /* events too, not only warnings and errors */
} Logger;

typedef struct {
    Phase phase;
    bool stale; /* outputs lag behind inputs, parameters or state */
    double values[COUNT];
} Snapshot;

typedef struct Saved Saved; /* a snapshot that the tool has */

typedef struct {
    Snapshot now;        /* all that save and restore touch */
    Saved *saved;        /* the latest; they form a list, so that others can be told from them */
    bool model_exchange; /* a tool's solver has it; else it steps by itself */
    Logger logger;
    char name[]; /* with the 0 */
} Instance;

static inline bool is_finite(double value) { return value - value == 0.0; }

/* NULL with a message when the token is not the one this binary was built with, or when the model
 * has no Model Exchange. */
Instance *instance_new(const char *name, const char *token, bool model_exchange, Logger logger);
void instance_free(Instance *instance);

/* OK when the instance is in one of `phases`, else ERROR with a message that names the call. */
Status instance_require(Instance *instance, int phases, const char *call);

Status instance_set_time(Instance *instance, double start);
Status instance_enter_initialization(Instance *instance);
Status instance_exit_initialization(Instance *instance);
Status instance_step(Instance *instance, double time, double h);
Status instance_terminate(Instance *instance);
Status instance_reset(Instance *instance);

/* Bring the outputs up to date before they are read; in Model Exchange the derivatives as well. */
void instance_refresh(Instance *instance);

/* OK when variable `reference` exists and is of `type`. A derivative is then up to date. */
Status instance_check(Instance *instance, uint32_t reference, Type type, const char *call);
/* ERROR: the tool gave NULL where something must be. */
Status instance_lacks(Instance *instance, const char *call);
/* ERROR: that many references were given with another number of values. */
Status instance_mismatch(Instance *instance, size_t references, size_t values, const char *call);
/* OK when it may be set now, and to this value, by causality, phase and range. */
Status instance_accepts(Instance *instance, uint32_t reference, double value, const char *call);
/* Sets what was accepted. */
void instance_put(Instance *instance, uint32_t reference, double value);

/* Save into *snapshot, which is made when it is NULL; restore from it; free it. A snapshot that is
 * not this instance's, or that was freed, is an ERROR. */
Status instance_save(Instance *instance, void **snapshot);
Status instance_restore(Instance *instance, const void *snapshot);
Status instance_forget(Instance *instance, void **snapshot);
void instance_forget_all(Instance *instance);

/* A snapshot as bytes that another process with the same FMU can read. */
Status instance_serialized_size(Instance *instance, const void *snapshot, size_t *size);
Status instance_serialize(Instance *instance, const void *snapshot, uint8_t bytes[], size_t size);
Status instance_deserialize(Instance *instance, const uint8_t bytes[], size_t size,
                            void **snapshot);

/* Choose what is logged: nothing but warnings and errors, or events of the categories too. */
Status instance_log(Instance *instance, bool on, size_t count, const char *const categories[]);

/* ERROR: modelDescription.xml does not declare what was called. Takes a missing instance. */
Status instance_unavailable(Instance *instance, const char *call);

#ifdef __GNUC__
__attribute__((format(printf, 4, 5)))
#endif
Status instance_report(Instance *instance, Status status, const char *category, const char *format,
                       ...);

#endif
