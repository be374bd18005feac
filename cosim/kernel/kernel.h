/* Steps a whole run of coupled FMUs without leaving C.
 *
 * cosim/kernel/structures.py reads the structures of the headers from their text.
 * All signals of one point in time lie side by side in a row of doubles: inputs from outside first,
 * then the columns of each component. Row n belongs to time start + n * step. */
#ifndef COSIM_KERNEL_H
#define COSIM_KERNEL_H

#include <fmi2FunctionTypes.h>
#include <fmi3FunctionTypes.h>
#include <stdbool.h>
#include <stdint.h>

#ifdef EXPORT /* a container exports the functions of the standard only */
#elif defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* The functions taken from an FMU's binary, in the order in which Python fills the tables; first
 * those of a step. */
#define FMI2_CALLS(X)                                                                              \
    X(SetReal)                                                                                     \
    X(DoStep)                                                                                      \
    X(GetReal)                                                                                     \
    X(Instantiate)                                                                                 \
    X(FreeInstance)                                                                                \
    X(Reset)                                                                                       \
    X(SetupExperiment)                                                                             \
    X(EnterInitializationMode) X(ExitInitializationMode) X(Terminate)
#define FMI3_CALLS(X)                                                                              \
    X(SetFloat64)                                                                                  \
    X(DoStep)                                                                                      \
    X(GetFloat64)                                                                                  \
    X(InstantiateCoSimulation)                                                                     \
    X(FreeInstance)                                                                                \
    X(Reset)                                                                                       \
    X(EnterInitializationMode) X(ExitInitializationMode) X(Terminate)

#define FMI2_MEMBER(call) fmi2##call##TYPE *call;
#define FMI3_MEMBER(call) fmi3##call##TYPE *call;
typedef struct {
    FMI2_CALLS(FMI2_MEMBER)
} Fmi2;
typedef struct {
    FMI3_CALLS(FMI3_MEMBER)
} Fmi3;
typedef union {
    Fmi2 fmi2;
    Fmi3 fmi3;
} Calls;

/* Both versions agree in these, but for the name of the status type. */
typedef int StateCall(void *instance, void **state);
typedef int RestoreCall(void *instance, void *state);

/* Within one FMI version the setters differ in the type of the values only. */
typedef union {
    fmi2Status (*fmi2)(fmi2Component, const fmi2ValueReference[], size_t, const void *);
    fmi3Status (*fmi3)(fmi3Instance, const fmi3ValueReference[], size_t, const void *, size_t);
} Setter;

/* Start values of one type. */
typedef struct {
    Setter set;
    const char *call;
    int64_t late; /* in Initialization Mode, as inputs are; else before it */
    size_t n;
    const uint32_t *references; /* n */
    const void *values;         /* n, of the type that set takes */
} Setting;

/* Values that a component is given when a step is done. */
typedef struct {
    int64_t step;
    int64_t component;
    Setting setting;
} Change;

/* Messages of a component since the start of the last run. */
typedef struct {
    fmi2CallbackFunctions callbacks; /* of FMI 2.0; their environment is that of FMI 3.0, too */
    int32_t severity;
    int32_t reason;     /* of the general path's own, when it is what failed */
    int32_t unknown;    /* the status that no standard has, when that is why */
    char message[1024]; /* the most severe */
    int64_t n_last;     /* messages; the last ten of them in turn, of 256 bytes each: */
    char last[2560];
    int64_t warnings; /* calls that returned warning; of the first of them: */
    const char *warned;
    double warned_at; /* s */
    char warning[1024];
} Log;

/* How a component finds its inputs in a row; PAIR: two that are scattered, as they are. */
enum Inputs { SIDE_BY_SIDE, PAIR, SCATTERED, NONE };

/* What a step reads comes first and close together: with thousands of components, memory decides.
 */
typedef struct {
    int32_t version; /* 2 or 3 */
    int32_t inputs;  /* an Inputs */
    void *instance;
    size_t n_inputs;
    const uint32_t *input_references;
    int64_t input_offset; /* of the first input, from the row of the present time */
    size_t n_outputs;
    const uint32_t *output_references;
    int64_t column; /* of the first output in a row */
    Calls call;
    const int64_t *input_offsets; /* of each input, and where they are gathered, if scattered */
    double *gathered;
    const double *scales; /* n_inputs factors, then as many offsets; NULL where nothing is scaled */
    size_t n_linked;      /* the first outputs: those that other components read */
    int64_t used;         /* not 0: must be reset before the next run */
    size_t n_settings;
    const Setting *settings;
    Log *log;
    double tolerance; /* relative, of its own solver; 0 where it is given none */
    double apart[3];  /* room: at 216 bytes, and a Run of 376, steps took twice as long in one
                         process of three, as memory happened to lie */
} Component;

/* What FMI 3.0 FMUs say about their last step. They need to be asked for all of it, but not to be
 * given a place that is fresh each time. */
typedef struct {
    fmi3Boolean event_handling_needed, terminate, early;
    fmi3Float64 last_successful_time;
} Answers;

/* An exposed input jumps within a step: the step is done in parts, one up to here. */
typedef struct {
    int64_t step;
    double t; /* s */
} InputEvent;

enum Outcome { FINISHED, PAUSED, FAILED, HALTED };

/* Why a run failed beyond what an FMI status says. */
enum Reason {
    NOT_FINITE = 100,
    TERMINATED,
    RETURNED_EARLY,
    NOT_SOLVED,
    UNKNOWN_STATUS, /* it is in the component's log */
    NO_STATE,
    RESTORED_WRONGLY,
};

typedef struct {
    Component *components; /* in the order in which they step */
    int64_t n_components;
    int64_t uniform; /* the FMI version of all components, if all have inputs and outputs; else 0 */
    int64_t jacobi;  /* not 0: all see the values of this point in time; else one after the other */
    int64_t constant_step; /* not 0: the FMUs are given step, else the distance of the two times */
    int64_t n_steps;
    double start, stop, step; /* s */
    const double *external; /* (n_steps + 1, n_external); NULL where n_external is 0, and where the
                               caller writes the inputs into the rows, step by step */
    int64_t n_external;
    double *rows;       /* (n_steps + 1, width), or (block + 1, width) where they are used again */
    int64_t width;      /* of a row */
    int64_t block;      /* steps between two looks at the values and the clock */
    int64_t used_again; /* not 0: the rows of a block are those of the next */
    double *record;     /* (n_steps / every + 1, n_selected), or NULL */
    int64_t ranged;     /* points of which the record has least, greatest and last values, or -1 */
    const int64_t *selected; /* columns */
    int64_t n_selected;
    int64_t every;       /* steps from one row of the record to the next */
    int64_t block_start; /* the step to which the first row belongs, where rows are used again */
    int64_t done;        /* steps completed; -1 before initialisation */
    int64_t closed;      /* the last step whose row was checked and recorded */
    double t, h;         /* s, of the present step: in memory, where no call can lose them */
    Answers answers;
    int64_t failed; /* component */
    int64_t output; /* of that component, where its value is not finite */
    int64_t status; /* an FMI status or a Reason */
    const char *call;
    struct Loop *initial;      /* what must agree before the first step, or NULL; see coupling.h */
    struct Coupling *coupling; /* NULL where inputs hold and nothing is solved or repeated */
    struct Loop *unsolved;
    int64_t allows_nan;    /* not 0: values need not be finite */
    const Change *changes; /* n_changes, in the order of their steps */
    int64_t n_changes, next_change;
    int64_t halt; /* the step after which to hand back; n_steps to go through to the end */
    int64_t n_events;
    const InputEvent *events;   /* as they follow each other */
    const double *event_inputs; /* (n_events, n_external), from then on */
    double *parts;              /* (2, width), where a step is done in parts */
    int64_t event;              /* the next one */
    int64_t event_end;          /* the number of its step's end; 0 where none follows */
    uint8_t *moved;   /* n_components, or NULL: is set where outputs are not what they began with */
    double *began;    /* (width), or NULL: the first row */
    int64_t apart[2]; /* likewise */
} Run;

EXPORT void instantiate(Component *c, const char *name, const char *token, const char *resources);
EXPORT void release(Component *c);
void clear_log(Log *log);
__attribute__((cold)) void note_warning(Log *log, const char *call, double t);
void log_fmi3(fmi3InstanceEnvironment, fmi3Status, fmi3String category, fmi3String message);

/* A message that names no instance belongs to the call that its thread is in. Take it into the log
 * of the component that was called; one from an earlier step, by the clock, is dropped. */
__attribute__((cold)) void take_stray(Log *log);
void keep_time(const double *clock); /* s; NULL: none */

/* Start or go on with a run. PAUSED about once a second, so that the caller can serve signals;
 * HALTED when step halt is reached: with another halt, it goes on from there. */
EXPORT enum Outcome advance(Run *run);

/* Take the rows of a block whose last step failed into the record, and one more, which the caller
 * has written, if the run went further. False where a value is not finite. */
EXPORT bool end_early(Run *run, bool further);

/* The row of step n. */
static inline double *row_of(const Run *run, int64_t n) {
    return run->rows + (run->used_again ? n - run->block_start : n) * run->width;
}

#endif
