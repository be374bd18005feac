/* The inside of a container. */
#ifndef COSIM_INSIDE_H
#define COSIM_INSIDE_H

#include "access.h"
#include "calls.h"
#include "container.h"
#include "system.h" /* generated: TOKEN, STEP, PARTS, STARTS, VARIABLES and their numbers */

struct Instance {
    Run run;
    Component components[N_PARTS];
    Access access[N_PARTS];
    Log logs[N_PARTS];
    double gathered[N_PARTS][MOST_INPUTS];
    double rows[2 * WIDTH]; /* of the present and of the next point in time */
    Phase phase;
    bool stale; /* in initialisation: what was set has not reached the outputs */
    bool stop_defined;
    Logger logger;
    char name[256];
    char resources[3072];
};

/* Pass a message on; returns the status. */
Status report(const Instance *x, Status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* In initialisation: carry outputs to the inputs they are connected to, until nothing changes. */
Status settle(Instance *x);

/* A call on a component failed: no more steps. */
Status part_failed(Instance *x, int part, const char *call, int status);

#endif
