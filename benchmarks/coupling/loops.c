/* What the kernel is measured against: the ring stepped by hand. -DFMI=2 or -DFMI=3. */
#include "ring.h"
#include <fmi2FunctionTypes.h>
#include <fmi3FunctionTypes.h>
#include <stdbool.h>

#define EXPORT __attribute__((visibility("default")))
#if FMI == 2
typedef struct {
    void *c;
    fmi2SetRealTYPE *set;
    fmi2DoStepTYPE *step;
    fmi2GetRealTYPE *get;
    fmi2ResetTYPE *reset;
    fmi2EnterInitializationModeTYPE *enter;
    fmi2ExitInitializationModeTYPE *leave;
} Fmu;
#define SET(f, r, n, v) (int)f.set(f.c, r, n, v)
#define GET(f, r, n, v) (int)f.get(f.c, r, n, v)
#define STEP(f) (int)f.step(f.c, t, h, fmi2True)
#define ENTER(f) (int)f.enter(f.c)
#else
typedef struct {
    void *c;
    fmi3SetFloat64TYPE *set;
    fmi3DoStepTYPE *step;
    fmi3GetFloat64TYPE *get;
    fmi3ResetTYPE *reset;
    fmi3EnterInitializationModeTYPE *enter;
    fmi3ExitInitializationModeTYPE *leave;
} Fmu;
#define SET(f, r, n, v) (int)f.set(f.c, r, n, v, n)
#define GET(f, r, n, v) (int)f.get(f.c, r, n, v, n)
#define STEP(f) (int)f.step(f.c, t, h, true, &event, &terminate, &early, &reached)
#define ENTER(f) (int)f.enter(f.c, false, 0.0, 0.0, false, 0.0)
#endif

static const unsigned R0[] = {0}, R1[] = {1}, R01[] = {0, 1}, R23[] = {2, 3}, R45[] = {4, 5};
static Fmu C, M, F; /* controller, mass, friction */

EXPORT void use(const Fmu fmus[3]) {
    C = fmus[0];
    M = fmus[1];
    F = fmus[2];
}

static int restart(void) {
    int s = (int)C.reset(C.c) | (int)M.reset(M.c) | (int)F.reset(F.c);
    s |= ENTER(C) | ENTER(M) | ENTER(F);
    return s | (int)C.leave(C.c) | (int)M.leave(M.c) | (int)F.leave(F.c);
}

#if FMI == 3
#define ANSWERS                                                                                    \
    bool event, terminate, early;                                                                  \
    double reached;
#else
#define ANSWERS
#endif

static void keep(double row[4], double u, double v, double x, double f) {
    row[0] = u;
    row[1] = v;
    row[2] = x;
    row[3] = f;
}

/* Values go through variables of the master; every output of every step is kept: u, v, x, f. */
EXPORT int plain(long n, double h, double *kept) {
    ANSWERS
    double vx[2] = {0.0, 0.0}, u = 0.0, f = 0.0, in[2];
    int s = restart();
    for (long k = 0; k < n; k++) {
        const double t = (double)k * h;
        s |= SET(C, R0, 1, vx);
        in[0] = u;
        in[1] = f;
        s |= SET(M, R01, 2, in) | SET(F, R0, 1, vx);
        s |= STEP(C) | STEP(M) | STEP(F);
        s |= GET(C, R1, 1, &u) | GET(M, R23, 2, vx) | GET(F, R1, 1, &f);
        keep(kept + 4 * k, u, vx[0], vx[1], f);
    }
    return s;
}

/* The same in Gauss-Seidel order: each sees what those before it gave. */
EXPORT int in_turn(long n, double h, double *kept) {
    ANSWERS
    double vx[2] = {0.0, 0.0}, u = 0.0, f = 0.0, in[2];
    int s = restart();
    for (long k = 0; k < n; k++) {
        const double t = (double)k * h;
        s |= SET(C, R0, 1, vx);
        s |= STEP(C);
        s |= GET(C, R1, 1, &u);
        in[0] = u;
        in[1] = f;
        s |= SET(M, R01, 2, in);
        s |= STEP(M);
        s |= GET(M, R23, 2, vx);
        s |= SET(F, R0, 1, vx);
        s |= STEP(F);
        s |= GET(F, R1, 1, &f);
        keep(kept + 4 * k, u, vx[0], vx[1], f);
    }
    return s;
}

/* No master can be faster: nothing is copied, kept or looked at. */
EXPORT int calls_in_turn(long n, double h, double *kept) {
    ANSWERS
    double vx[2] = {0.0, 0.0}, uf[2] = {0.0, 0.0};
    (void)kept;
    const int s = restart();
    for (long k = 0; k < n; k++) {
        const double t = (double)k * h;
        (void)SET(C, R0, 1, vx), (void)STEP(C), (void)GET(C, R1, 1, &uf[0]);
        (void)SET(M, R01, 2, uf), (void)STEP(M), (void)GET(M, R23, 2, vx);
        (void)SET(F, R0, 1, vx), (void)STEP(F), (void)GET(F, R1, 1, &uf[1]);
    }
    return s;
}

/* Start again, set two parameters, run, sum up the squared error; nothing is kept. */
EXPORT double candidate(long n, double h, double K_p, double K_i, bool turns) {
    ANSWERS
    const double gains[2] = {K_p, K_i};
    double v = 0.0, uf[2] = {0.0, 0.0}, cost = 0.0;
    int s = restart() | SET(C, R45, 2, gains);
    for (long k = 0; turns && k < n; k++) {
        const double t = (double)k * h;
        s |= SET(C, R0, 1, &v);
        s |= STEP(C);
        s |= GET(C, R1, 1, &uf[0]);
        s |= SET(M, R01, 2, uf);
        s |= STEP(M);
        s |= GET(M, R23, 1, &v);
        s |= SET(F, R0, 1, &v);
        s |= STEP(F);
        s |= GET(F, R1, 1, &uf[1]);
        cost += (0.2 - v) * (0.2 - v);
    }
    for (long k = 0; !turns && k < n; k++) {
        const double t = (double)k * h;
        s |= SET(C, R0, 1, &v) | SET(M, R01, 2, uf) | SET(F, R0, 1, &v);
        s |= STEP(C) | STEP(M) | STEP(F);
        s |= GET(C, R1, 1, &uf[0]) | GET(M, R23, 1, &v) | GET(F, R1, 1, &uf[1]);
        cost += (0.2 - v) * (0.2 - v);
    }
    return s ? -1.0 : cost;
}

/* The same physics in one loop, without FMI. */
EXPORT int fused(long n, double h, double *kept) {
    double c[6] = CONTROLLER_START, m[6] = MASS_START, f[6] = FRICTION_START;
    for (long k = 0; k < n; k++) {
        c[0] = f[0] = m[2];
        m[0] = c[1];
        m[1] = f[1];
        step_controller(c, h);
        step_mass(m, h);
        step_friction(f, h);
        keep(kept + 4 * k, c[1], m[2], m[3], f[1]);
    }
    return 0;
}
