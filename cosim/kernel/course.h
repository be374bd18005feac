/* How an exposed input of Model Exchange runs over time: a table that is known as a whole. */
#ifndef COSIM_COURSE_H
#define COSIM_COURSE_H

#include <stddef.h>
#include <stdint.h>

typedef struct {
    size_t n;                 /* 0 where only the values at the communication points are known */
    const double *t, *values; /* n; s, never falling */
    int64_t held;             /* each value until the next time, else straight lines */
} Course;

/* Both know of the jumps up to time passed that they were made, and of all others that they were
 * not: at its time a jump has two values. */
double value_of(const Course *c, double t, double passed);
double next_jump(const Course *c, double passed); /* infinite where there is none */

#endif
