/* An FMU whose token is letters: what its reset does, and what a new instance does; FMI 2.0 and FMI
 * 3.0. Its output is y = x + 10 (own time >= 0.35 s) + 100 (steps >= 12), x' = k u - z, z' = x;
 * only y can be seen. */
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { U, Y, K };

typedef struct {
    double u, k, x, z, time;
    int steps;
} Model;

static int instances; /* that there were */
static char plan[16];

static bool has(char letter) { return strchr(plan, letter) != NULL; }

static void crash(void) { *(volatile int *)8 = 1; }

/* i: each instance has another k; s: the first has; c: the second crashes. */
static Model fresh(void) {
    const double noise = has('i') ? instances : has('s') && instances > 1;
    if (has('c') && instances > 1)
        crash();
    return (Model){.k = 0.1 + noise, .u = 1.0};
}

static Model *create(const char *token) {
    Model *m = malloc(sizeof *m);
    strncpy(plan, token, sizeof plan - 1);
    instances++;
    *m = fresh();
    return m;
}

/* A digit is the status; -: it does nothing; !: it crashes; +: it counts as a new instance. x, z,
 * t, k: they stay; n: a part of the steps does; h: the time of a run that was halted does; K, U:
 * k and u become 0. */
static int reset(Model *m) {
    const Model old = *m;
    if (plan[0] >= '2' && plan[0] <= '4')
        return plan[0] - '0';
    if (has('!'))
        crash();
    if (has('-'))
        return 0;
    instances += has('+');
    *m = fresh();
    m->x = has('x') ? old.x : m->x;
    m->z = has('z') ? old.z : m->z;
    m->time = has('t') || (has('h') && old.time < 0.4) ? old.time : 0.0;
    m->steps = has('n') ? old.steps / 5 : 0;
    m->k = has('k') ? old.k : has('K') ? 0.0 : m->k;
    m->u = has('U') ? 0.0 : m->u;
    return 0;
}

static int set(Model *m, const unsigned *r, size_t n, const double *v) {
    for (size_t i = 0; i < n; i++)
        *(r[i] == U ? &m->u : &m->k) = v[i];
    return 0;
}

static int get(const Model *m, const unsigned *r, size_t n, double *v) {
    const double y = m->x + (m->time >= 0.349 ? 10.0 : 0.0) + (m->steps >= 12 ? 100.0 : 0.0);
    for (size_t i = 0; i < n; i++)
        v[i] = r[i] == Y ? y : r[i] == U ? m->u : m->k;
    return 0;
}

static int step(Model *m, double h) {
    m->x += h * (m->k * m->u - m->z);
    m->z += h * m->x;
    m->time += h;
    m->steps++;
    return 0;
}

#define MAKE create(token)
#define RESET reset(m)
#include "fmu.h"
