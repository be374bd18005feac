/* Steps a system of models in lanes: a whole run of LANES candidates in one call, in the order of
 * cosim's kernel with Gauss-Seidel coupling. */
#ifndef RUN_H
#define RUN_H

#include "lanes.h"

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* The functions of a model: values [COUNT] as an instance of the FMU has them. */
typedef void Start(double t, V *values, M live);
typedef M Step(double t, double h, V *values, M live); /* the lanes in which it failed */
typedef struct {
    Start *start;
    Step *step;
} LaneModel;

/* Places are numbers of vectors among the values of all components. */

typedef struct {
    int64_t target, source; /* places; source is -1 for a column of the exposed inputs */
    int64_t column;
} Wire;

typedef struct {
    const LaneModel *model;
    int64_t first; /* place of its values */
    const Wire *wires;
    int64_t n_wires;
    const int64_t *checked; /* places of the outputs that have to be finite */
    int64_t n_checked;
} LaneComponent;

/* What is exposed or recorded goes in blocks of as many points in time, between memory in which the
 * lanes are side by side, and that of each lane. */
enum { BLOCK = 64 };

typedef struct {
    const LaneComponent *components; /* in the order in which they step */
    int64_t n_components;
    double start, step; /* s */
    int64_t constant_step;
    int64_t n_external, n_recorded;
    const int64_t *recorded;       /* places */
    V *values;                     /* of all components */
    V *block;                      /* [BLOCK * (n_external + n_recorded)] */
    const double *const *external; /* each lane's (n_steps + 1, n_external) */
    double *const *record;         /* each lane's (n_recorded, room) */
    int64_t room;
    const int64_t *n_steps; /* of each lane; 0: it has none */
    int64_t *failed;        /* of each lane; it has stopped then */
} LaneRun;

#endif
