/* One model of ring.h as an FMU, FMI 2.0 and FMI 3.0 in one library: -DMODEL_START and -DMODEL_STEP
 * choose it. */
#include "ring.h"
#include <stddef.h>
#include <string.h>

enum { N = 6 };
typedef struct {
    double x[N];
} Model;

static void start(Model *m) {
    const double x[N] = MODEL_START;
    memcpy(m->x, x, sizeof x);
}

static int set(Model *m, const unsigned r[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= N) {
            return 3;
        }
        m->x[r[i]] = v[i];
    }
    return 0;
}

static int get(const Model *m, const unsigned r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++) {
        if (r[i] >= N) {
            return 3;
        }
        v[i] = m->x[r[i]];
    }
    return 0;
}

#define STEP (MODEL_STEP(((Model *)m)->x, h), 0)
#include "fmu.h"
