/* An FMU that does more than step on doubles, seen by the kernel as a plain FMI 2.0 one.
 *
 * The kernel's loop knows SetReal, DoStep and GetReal on rows of doubles. The general path gives it
 * these for FMUs with other types, arrays, event mode or Model Exchange. References are then places
 * in its lists of ports.*/
#ifndef COSIM_GENERAL_PATH_H
#define COSIM_GENERAL_PATH_H

#include "arithmetic.h"
#include "kernel.h"
#include "mark.h"
#include <float.h>
#include <math.h>

typedef void AnyCall(void);

/* place, name in FMI 2.0, name in FMI 3.0, what it is needed for: (C)o-simulation, (M)odel
 * exchange, (E)vent mode, (S)tructural parameters, (R)ollback, cloc(K)s. A dash: the version has no
 * such call. */
#define GENERAL_CALLS(X)                                                                           \
    X(INSTANTIATE_CS, "fmi2Instantiate", "fmi3InstantiateCoSimulation", "C")                       \
    X(INSTANTIATE_ME, "fmi2Instantiate", "fmi3InstantiateModelExchange", "M")                      \
    X(FREE_INSTANCE, "fmi2FreeInstance", "fmi3FreeInstance", "CM")                                 \
    X(RESET, "fmi2Reset", "fmi3Reset", "CM")                                                       \
    X(SETUP_EXPERIMENT, "fmi2SetupExperiment", "-", "CM")                                          \
    X(ENTER_CONFIGURATION, "-", "fmi3EnterConfigurationMode", "S")                                 \
    X(EXIT_CONFIGURATION, "-", "fmi3ExitConfigurationMode", "S")                                   \
    X(ENTER_INITIALIZATION, "fmi2EnterInitializationMode", "fmi3EnterInitializationMode", "CM")    \
    X(EXIT_INITIALIZATION, "fmi2ExitInitializationMode", "fmi3ExitInitializationMode", "CM")       \
    X(TERMINATE, "fmi2Terminate", "fmi3Terminate", "CM")                                           \
    X(DO_STEP, "fmi2DoStep", "fmi3DoStep", "C")                                                    \
    X(GET_STATE, "fmi2GetFMUstate", "fmi3GetFMUState", "R")                                        \
    X(SET_STATE, "fmi2SetFMUstate", "fmi3SetFMUState", "R")                                        \
    X(FREE_STATE, "fmi2FreeFMUstate", "fmi3FreeFMUState", "R")                                     \
    X(ENTER_STEP_MODE, "-", "fmi3EnterStepMode", "E")                                              \
    X(ENTER_EVENT_MODE, "fmi2EnterEventMode", "fmi3EnterEventMode", "ME")                          \
    X(UPDATE_DISCRETE_STATES, "fmi2NewDiscreteStates", "fmi3UpdateDiscreteStates", "ME")           \
    X(ENTER_CONTINUOUS_TIME, "fmi2EnterContinuousTimeMode", "fmi3EnterContinuousTimeMode", "M")    \
    X(SET_TIME, "fmi2SetTime", "fmi3SetTime", "M")                                                 \
    X(GET_STATES, "fmi2GetContinuousStates", "fmi3GetContinuousStates", "M")                       \
    X(SET_STATES, "fmi2SetContinuousStates", "fmi3SetContinuousStates", "M")                       \
    X(GET_DERIVATIVES, "fmi2GetDerivatives", "fmi3GetContinuousStateDerivatives", "M")             \
    X(GET_INDICATORS, "fmi2GetEventIndicators", "fmi3GetEventIndicators", "M")                     \
    X(GET_NOMINALS, "fmi2GetNominalsOfContinuousStates", "fmi3GetNominalsOfContinuousStates", "M") \
    X(COUNT_STATES, "-", "fmi3GetNumberOfContinuousStates", "M")                                   \
    X(COUNT_INDICATORS, "-", "fmi3GetNumberOfEventIndicators", "M")                                \
    X(COMPLETED_STEP, "fmi2CompletedIntegratorStep", "fmi3CompletedIntegratorStep", "M")           \
    X(SET_CLOCK, "-", "fmi3SetClock", "K")                                                         \
    X(GET_INTERVAL, "-", "fmi3GetIntervalDecimal", "K")

#define PLACE(place, fmi2, fmi3, interfaces) place,
enum Call { GENERAL_CALLS(PLACE) N_CALLS };

/* How a variable's value is stored, by its C type. Strings and Binary are only ever start values.
 */
#define STORED_TYPES(X)                                                                            \
    X(FLOAT64, double)                                                                             \
    X(FLOAT32, float)                                                                              \
    X(INT8, int8_t)                                                                                \
    X(UINT8, uint8_t)                                                                              \
    X(INT16, int16_t)                                                                              \
    X(UINT16, uint16_t)                                                                            \
    X(INT32, int32_t)                                                                              \
    X(UINT32, uint32_t)                                                                            \
    X(INT64, int64_t)                                                                              \
    X(UINT64, uint64_t)                                                                            \
    X(TRUTH, bool)

#define STORED(place, type) place,
enum Stored { STORED_TYPES(STORED) TEXT };

/* Variables that one call gets or sets. Arrays lie one after the other in values. */
typedef struct {
    AnyCall *call;
    const char *name;
    int64_t stored; /* enum Stored */
    int64_t discrete;
    int64_t clock; /* triggered clocks, whose values are whether they tick */
    size_t n;
    const uint32_t *references; /* n */
    size_t n_values;
    void *values;
    const size_t *sizes; /* n_values, of Binary; else NULL */
} Group;

typedef struct {
    size_t n;
    Group *groups;
} Groups;

/* How an exposed input of Model Exchange runs over time: a table that is known as a whole. */
typedef struct {
    size_t n;                 /* 0 where only the values at the communication points are known */
    const double *t, *values; /* n; s, never falling */
    int64_t held;             /* each value until the next time, else straight lines */
} Course;

/* A column of the kernel's rows: one element of one group. */
typedef struct {
    int64_t group;
    int64_t place;
    int64_t ahead; /* Model Exchange: the kernel gives the value at the end of the step */
} Port;

/* When the FMU is asked for the interval of a clock: never, as the description has it; once; at
 * each tick; at each event, from which it then counts. */
enum Asked { NEVER, ONCE, AT_TICKS, AT_EVENTS };

/* An input clock that ticks by time. */
typedef struct {
    uint32_t reference;
    int32_t asked;          /* enum Asked */
    double interval, shift; /* s; the first tick is at start + shift */
    double begin;           /* s, from where intervals count */
    int64_t ticks;          /* since begin */
    double next;            /* s; infinite where it is not known */
} Clock;

typedef struct Integrator Integrator;
typedef struct Cvode Cvode;

typedef struct {
    Log log; /* first, and its callbacks are: by their address Instantiate finds the component */
    int64_t version;
    int64_t model_exchange;
    int64_t event_mode;  /* Co-Simulation: eventModeUsed and earlyReturnAllowed */
    int64_t notes_steps; /* Model Exchange: CompletedIntegratorStep is needed */
    AnyCall *call[N_CALLS];
    Groups structure;    /* start values of structural parameters */
    Groups start_values; /* of all others */
    Groups late;         /* those of inputs, set in Initialization Mode */
    Groups inputs, outputs;
    const Port *input_ports, *output_ports;
    size_t n_inputs;
    double *before, *after; /* n_inputs, values of the input ports at the two ends of a step */
    int64_t follows;        /* Model Exchange: inputs are polynomials; after is their begin ... */
    double *rates;          /* (2, n_inputs): ... and these are their derivatives there */
    const Course *courses;  /* n_inputs, Model Exchange */
    const Cvode *cvode;     /* Model Exchange */
    double tolerance; /* relative, of Model Exchange; times the nominal value the absolute one */
    double own_tolerance; /* Co-Simulation: 0 where the FMU is given none */
    size_t n_states, n_indicators;
    void *instance;
    Integrator *integrator;
    const char *called; /* the last call that did not return OK or warning */
    double time;        /* reached, s */
    double start, stop; /* of the run, s */
    double near;        /* s: two times this close are meant to be the same */
    double next_event;  /* s; infinite where none is due */
    double next_jump;   /* of an input that follows a course, likewise */
    double passed;      /* s: jumps up to here were made */
    double next_tick;   /* of a clock, s; likewise */
    size_t n_clocks;
    Clock *clocks;
    int64_t running; /* initialisation is over */
    int64_t states_changed;
    int64_t ticks_read;    /* the ticks of output clocks were given to the kernel */
    int64_t retries_steps; /* a discarded step is taken back, and tried in parts */
    void *begun;           /* the state at the begin of a part */
    Answers answers;
} GeneralComponent;

/* Beside TERMINATED and the others of enum Reason. */
enum { TOO_MANY_EVENTS = 110, SOLVER_FAILED, OUT_OF_MEMORY, NO_SUCH_TIME };

/* What the files of the general path offer; each uses those above it only. What returns a
 * fmi2Status returns an FMI status or a Reason. */

/* general_calls.c */
#ifdef MARKED
AnyCall *calling(const GeneralComponent *f, enum Call place);
#else
#define calling(f, place) ((f)->call[place])
#endif
fmi2Status simple_call(GeneralComponent *f, enum Call place);
fmi2Status checked(GeneralComponent *f, enum Call place, int status);   /* what the FMU returned */
fmi2Status noted(GeneralComponent *f, const char *call, int status);    /* likewise */
fmi2Status failed_by(GeneralComponent *f, enum Call place, int reason); /* a Reason */

/* values.c */
fmi2Status transfer(GeneralComponent *f, const Group *group);
fmi2Status set_groups(GeneralComponent *f, const Groups *groups);
void store(const Group *group, int64_t place, double value);
bool take_values(GeneralComponent *f, const uint32_t ports[], size_t n, const double values[]);
fmi2Status set_taken(GeneralComponent *f); /* give the FMU what was taken, but for events */
fmi2Status get_values(GeneralComponent *f, const uint32_t ports[], size_t n, double values[]);

/* events.c */
fmi2Status begin_clocks(GeneralComponent *f);
void schedule_ticks(GeneralComponent *f);       /* find the next tick of all clocks */
fmi2Status trigger_clocks(GeneralComponent *f); /* of the inputs, those that tick */
void forget_ticks(GeneralComponent *f);         /* of the outputs, which the kernel was given */
fmi2Status update_discrete_states(GeneralComponent *f);
fmi2Status handle_event(GeneralComponent *f, bool with_inputs);

/* exchange.c */
fmi2Status begin_exchange(GeneralComponent *f);
fmi2Status step_exchange(GeneralComponent *f, double t, double h);
fmi2Status restart_exchange(GeneralComponent *f);
void seek_jump(GeneralComponent *f); /* find the next jump after those that were passed */
void end_exchange(GeneralComponent *f);

/* saving.c, and below those that the kernel calls */
fmi2Status step_once(GeneralComponent *f, double t, double h); /* its answers are in answers */
/* After the FMU was brought into a saved state, and the fields of the general path with it: */
EXPORT fmi2Status general_go_on(GeneralComponent *f);

/* Whether an input of a group is an event: a clock that ticks, a discrete one that changes. */
static inline bool is_event(const Group *g, double before, double value) {
    return g->clock ? value != 0.0 : g->discrete && value != before;
}

/* More in a row mean that events never come to an end. */
enum { MAX_ITERATIONS = 10000 };

/* An event that is not due lies at infinity. */
static inline bool is_due(const GeneralComponent *f, double event, double t) {
    return event <= t + f->near;
}

/* Rounding makes two times differ by so much. */
static inline double rounding_of(double t) { return 4.0 * DBL_EPSILON * fabs(t); }

#define OK(status) ((unsigned)(status) <= fmi2Warning)
#define TRY_STATUS(action)                                                                         \
    do {                                                                                           \
        const fmi2Status status_ = (action);                                                       \
        if (!OK(status_)) {                                                                        \
            return status_;                                                                        \
        }                                                                                          \
    } while (0)

/* Set tunable parameters between two steps, as an event where the FMU knows events. */
EXPORT fmi2Status general_tune(fmi2Component c, const fmi2ValueReference references[], size_t n,
                               const void *group);

/* Under these names the kernel's table of FMI 2.0 calls finds them. */
EXPORT fmi2InstantiateTYPE general_Instantiate;
EXPORT fmi2FreeInstanceTYPE general_FreeInstance;
EXPORT fmi2ResetTYPE general_Reset;
EXPORT fmi2SetupExperimentTYPE general_SetupExperiment;
EXPORT fmi2EnterInitializationModeTYPE general_EnterInitializationMode;
EXPORT fmi2ExitInitializationModeTYPE general_ExitInitializationMode;
EXPORT fmi2SetRealTYPE general_SetReal;
EXPORT fmi2SetRealInputDerivativesTYPE general_SetRealInputDerivatives;
EXPORT fmi2GetRealTYPE general_GetReal;
EXPORT fmi2DoStepTYPE general_DoStep;
EXPORT fmi2TerminateTYPE general_Terminate;
EXPORT fmi2GetFMUstateTYPE general_GetFMUstate;
EXPORT fmi2SetFMUstateTYPE general_SetFMUstate;
EXPORT fmi2FreeFMUstateTYPE general_FreeFMUstate;

#endif
