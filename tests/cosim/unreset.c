/* An FMU whose reset is RESTART, a statement on m; FMI 2.0 and FMI 3.0. Its output is
 * y = x + 10 (own time >= 0.35 s) + 100 (steps >= 12), x' = k u - z, z' = x; only y can be seen. */
#include <stdlib.h>

enum { U, Y, K };

typedef struct {
    double u, k, x, z, time;
    int steps;
} Model;

static int instances; /* that there were */

static Model fresh(void) { return (Model){.k = 0.1 + NOISE * instances, .u = 1.0}; }

static Model *create(void) {
    Model *m = malloc(sizeof *m);
    instances++;
    *m = fresh();
    return m;
}

static int reset(Model *m) {
    const Model old = *m;
    (void)old;
    RESTART
    return 0;
}

static int set(Model *m, const unsigned *r, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++) {
        *(r[i] == U ? &m->u : &m->k) = v[i];
    }
    return 0;
}

static int get(const Model *m, const unsigned *r, size_t n, double *v) {
    const double y = m->x + (m->time >= 0.349 ? 10.0 : 0.0) + (m->steps >= 12 ? 100.0 : 0.0);
    for (size_t i = 0; i < n; i++) {
        v[i] = r[i] == Y ? y : r[i] == U ? m->u : m->k;
    }
    return 0;
}

static int step(Model *m, double h) {
    m->x += h * (m->k * m->u - m->z);
    m->z += h * m->x;
    m->time += h;
    m->steps++;
    return 0;
}

#define MAKE create()
#define RESET reset(m)
#include "fmu.h"
