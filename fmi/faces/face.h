/* The functions that an FMU implements; the C files beside this one put FMI 2.0 and FMI 3.0 over
 * them. One FMU has one kind of instance, so the table of functions is filled by the linker.
 *
 * Integers and Booleans pass as doubles. Each function that returns a status reports an ERROR to
 * the tool before it returns. `call` is the name of the function that the tool called. */
#ifndef FACE_H
#define FACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The numbers that both FMI 2.0 and FMI 3.0 give these. */
typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } Status;

/* Life cycle; a bit each, so that a call can name the phases it is legal in. */
typedef enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEPPING = 4,
    ENDED = 8,
    BROKEN = 16,
    EVENT = 32, /* this and the next in Model Exchange, in place of STEPPING */
    CONTINUOUS = 64,
} Phase;

#define ALIVE (INSTANTIATED | INITIALIZATION | STEPPING | EVENT | CONTINUOUS | ENDED)
#define ANY (ALIVE | BROKEN)

/* A derivative, and what else is of this type, is a real that is calculated when it is requested.
 */
typedef enum { REAL, INTEGER, BOOLEAN, STRING, DERIVATIVE } Type;

/* Where messages go: emit translates for the callback that the tool gave. */
typedef struct Logger {
    void (*emit)(const struct Logger *logger, const char *name, Status status, const char *category,
                 const char *message);
    void (*callback)(void); /* NULL: the tool wants no messages */
    void *environment;
    bool events; /* events too, not only warnings and errors */
} Logger;

typedef struct Instance Instance;

/* NULL with a message when the token is not the one this binary was built with, or when there is no
 * Model Exchange. */
Instance *instance_new(const char *name, const char *token, const char *resources,
                       bool model_exchange, Logger logger);
void instance_free(Instance *instance);

/* OK when the instance is in one of `phases`. */
Status instance_require(Instance *instance, int phases, const char *call);

/* The times of the run, before initialization. */
Status instance_set_up(Instance *instance, double start, bool stop_defined, double stop);
Status instance_enter_initialization(Instance *instance);
Status instance_exit_initialization(Instance *instance);
Status instance_step(Instance *instance, double time, double h);
Status instance_terminate(Instance *instance);
Status instance_reset(Instance *instance);
double instance_time(const Instance *instance);

/* The value of a variable, which must exist and be of `type`. */
Status instance_get(Instance *instance, uint32_t reference, Type type, double *value,
                    const char *call);
/* OK when it exists, is of `type` and may be set now, and to this value. */
Status instance_accepts(Instance *instance, uint32_t reference, Type type, double value,
                        const char *call);
/* Set what was accepted. */
Status instance_put(Instance *instance, uint32_t reference, double value);

/* OK when a variable exists and is of `type`. */
Status instance_check(Instance *instance, uint32_t reference, Type type, const char *call);
/* ERROR: the tool gave NULL where something must be. */
Status instance_lacks(Instance *instance, const char *call);
/* ERROR: that many references were given with another number of values. */
Status instance_mismatch(Instance *instance, size_t references, size_t values, const char *call);
/* ERROR: modelDescription.xml does not declare what was called. Takes a missing instance. */
Status instance_unavailable(Instance *instance, const char *call);

/* Save into *snapshot, which is made when it is NULL; restore from it; free it. */
Status instance_save(Instance *instance, void **snapshot);
Status instance_restore(Instance *instance, const void *snapshot);
Status instance_forget(Instance *instance, void **snapshot);

/* A snapshot as bytes that another process with the same FMU can read. */
Status instance_serialized_size(Instance *instance, const void *snapshot, size_t *size);
Status instance_serialize(Instance *instance, const void *snapshot, uint8_t bytes[], size_t size);
Status instance_deserialize(Instance *instance, const uint8_t bytes[], size_t size,
                            void **snapshot);

/* Choose what is logged: nothing but warnings and errors, or events of the categories too. */
Status instance_log(Instance *instance, bool on, size_t count, const char *const categories[]);

/* Model Exchange: the tool's solver moves time and states. */

/* Take what is due now, modes included. *changed: whether continuous states were set; *defined:
 * whether there is a next event, whose time is then *next. */
Status exchange_update(Instance *instance, bool *changed, bool *defined, double *next);

/* Go from event mode to continuous-time mode or back. */
Status exchange_enter(Instance *instance, Phase phase);

Status exchange_set_time(Instance *instance, double time);

/* A value for each of the continuous states, else ERROR. DISCARD: not finite there, so the solver
 * must take a smaller step. */
size_t exchange_count(const Instance *instance);
Status exchange_set_states(Instance *instance, const double states[], size_t count);
Status exchange_get_states(Instance *instance, double states[], size_t count);
Status exchange_get_derivatives(Instance *instance, double derivatives[], size_t count);
Status exchange_get_nominals(Instance *instance, double nominals[], size_t count);

/* A value for each event indicator, else ERROR. One falls below 0 where exchange_update has a mode
 * to change. */
size_t exchange_indicator_count(const Instance *instance);
Status exchange_get_indicators(Instance *instance, double indicators[], size_t count);

/* Products with the matrix of partial derivatives of derivatives and outputs by states and inputs,
 * at the present values: those that FMI calls directional and adjoint derivatives. */

/* Variables by value reference. */
typedef struct {
    const uint32_t *references;
    size_t count;
} Chosen;

/* DIRECTIONAL: sensitivity[k] = sum over l of d unknown k / d known l * seed[l].
 * ADJOINT: sensitivity[l] = sum over k of seed[k] * d unknown k / d known l. */
typedef enum { DIRECTIONAL, ADJOINT } Product;

Status slopes_multiply(Instance *instance, Product product, Chosen unknowns, Chosen knowns,
                       const double seed[], double sensitivity[], const char *call);

#endif
