/* Coupling beyond the plain orders of run.c: inputs that follow polynomials, loops that are solved,
 * steps of several lengths. One scheme covers all: components step in turn, and each input follows
 * the polynomial of a degree through the last known points of its source. A fresh input knows the
 * point at the end of the step too, because its source stepped before, or is guessed in a loop.
 */
#ifndef COSIM_COUPLING_H
#define COSIM_COUPLING_H

#include "kernel.h"

enum { MAX_DEGREE = 2, MAX_PAST = MAX_DEGREE + 1 };

/* What one input of a component follows. */
typedef struct {
    int64_t column;
    int64_t fresh;         /* not 0: the value at the end of the step is known */
    int64_t feeds_through; /* not 0: outputs show its value at the end of the step */
    int64_t holds;         /* not 0: a discrete value, which follows no polynomial */
} Link;

/* What a component needs here beyond kernel.h. */
typedef struct {
    const Link *links;    /* n_inputs */
    double *values;       /* n_inputs */
    int64_t interpolates; /* not 0: takes derivatives of its inputs */
    int64_t splits;       /* not 0: steps in two parts, with inputs at their end in the second */
    uint32_t *derivative_references; /* n_inputs * degree, if it interpolates */
    int32_t *derivative_orders;      /* likewise */
    double *derivatives;             /* likewise */
    fmi2SetRealInputDerivativesTYPE *set_derivatives;
    StateCall *save, *discard;
    RestoreCall *restore;
    void *state;     /* at the begin of the step */
    double *outputs; /* (n_outputs) then */
    double *again;   /* (n_outputs) when it was restored */
    int64_t proven;  /* not 0: in this run outputs have moved and come back */
    int64_t every;   /* its step in steps of the run */
} Member;

/* Equations w = G(w): G goes once through the components with w for the values they lack. */
typedef struct Loop {
    int64_t first, end;     /* components */
    int64_t n;              /* unknowns; 0 where nothing needs to be solved */
    const int64_t *columns; /* n: where the unknowns lie in a row */
    const double *nominal;  /* n */
    double tolerance;       /* of the unknowns, relative to the greater of value and nominal */
    int64_t max_iterations;
    double *inverse;  /* (n, n): of the Jacobian of G(w) - w */
    int64_t known;    /* not 0: the inverse is that of an earlier point */
    double *work;     /* (n, n) then 6 n */
    int64_t rollback; /* not 0: its components are saved before each step */
    int64_t worst;    /* where there was no solution: the unknown that changed most ... */
    double change;    /* ... and by how much in the last iteration, in its unit */
} Loop;

typedef struct Coupling {
    Member *members; /* one a component */
    int64_t n_members;
    Loop *loops; /* cover all components in their order */
    int64_t n_loops;
    int64_t degree; /* of the inputs' polynomials */
    double *past;   /* (MAX_PAST, width): rows at the last points in time, latest first */
    double *next;   /* (width): the row at the end of the step */
    double times[MAX_PAST];
    int64_t n_past;
    double tolerance;      /* of the prediction, likewise relative; 0: the step is constant */
    int64_t predicted;     /* degree of the prediction: less than that of the inputs where FMUs take
                              their mean, as the error is then of a lower order */
    double min_step;       /* s */
    double inner;          /* the step to try next, s */
    const double *nominal; /* (width) */
    int64_t steps, sweeps, rejected;
    double t, h;        /* the step that is tried, s */
    int64_t swept;      /* not 0: the FMUs are no longer at its begin */
    const double *ends; /* (n_steps + 1, n_external): inputs from outside at the end of the step
                           before each point in time; others than there where they jump;
                           NULL: the same */
} Coupling;

/* What an input does between communication points: a0 + a1 s + a2 s^2, s seconds after the begin of
 * the step */
typedef struct {
    double a[MAX_DEGREE + 1];
} Polynomial;
Polynomial hold(const Run *run, int64_t column, bool fresh, double t, double h, int64_t degree);
double value_at(Polynomial p, double s);
double mean_over(Polynomial p, double h);

/* rollback.c */
bool save(Run *run, int64_t first, int64_t end);
bool restore(Run *run, int64_t first, int64_t end);
EXPORT void forget(Run *run); /* free what was saved */

/* loop.c: find w with G(w) = w, in place in values; sweep puts G over it. */
typedef bool Sweep(Run *run, Loop *loop);
bool solve(Run *run, Loop *loop, double *values, Sweep *sweep);

/* coupled.c, which uses the two above */
bool begin_coupled(Run *run);
bool attempt(Run *run, double t, double h);       /* from t over h, to Coupling.next */
void keep(Run *run, const double *row, double t); /* as the latest of the past */

/* adaptive.c, which uses all above */
bool couple_until(Run *run, int64_t end); /* as many steps as lead there */

#endif
