#include "course.h"
#include <math.h>
#include <stdbool.h>

/* How many of the times are not after t. */
static size_t count(const Course *c, double t) {
    size_t low = 0, high = c->n;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (c->t[middle] <= t) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

double value_of(const Course *c, double t, double passed) {
    size_t i = count(c, c->held ? passed : fmax(t, passed));
    if (i == 0) {
        return c->values[0];
    }
    i--;
    const bool before_jump = !c->held && c->t[i] > passed && i > 0 && c->t[i] == c->t[i - 1];
    while (before_jump && i > 0 && c->t[i] == c->t[i - 1]) {
        i--;
    }
    if (c->held || before_jump || i + 1 == c->n) {
        return c->values[i];
    }
    const double share = (c->t[i + 1] - t) / (c->t[i + 1] - c->t[i]); /* as cosim.Table has it */
    return share * c->values[i] + (1.0 - share) * c->values[i + 1];
}

double next_jump(const Course *c, double passed) {
    for (size_t i = count(c, passed); i < c->n; i++) {
        if (i > 0 && (c->t[i] == c->t[i - 1] || (c->held && c->values[i] != c->values[i - 1]))) {
            return c->t[i];
        }
    }
    return INFINITY;
}
