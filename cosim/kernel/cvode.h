/* The functions of SUNDIALS 7 that Model Exchange calls. Python finds them in the library that FMPy
 * brings along; vectors, matrices and memory are opaque. */
#ifndef COSIM_CVODE_H
#define COSIM_CVODE_H

#include "kernel.h"

enum { CV_BDF = 2, CV_NORMAL = 1, CV_ROOT_RETURN = 2 };

typedef int Rates(double t, void *states, void *rates, void *user);
typedef int Roots(double t, void *states, double *roots, void *user);
typedef void Complaint(int line, const char *function, const char *file, const char *message,
                       int code, void *user, void *context);

#define CVODE_CALLS(X)                                                                             \
    X(int, SUNContext_Create, (int communicator, void **context))                                  \
    X(int, SUNContext_Free, (void **context))                                                      \
    X(int, SUNContext_ClearErrHandlers, (void *context))                                           \
    X(int, SUNContext_PushErrHandler, (void *context, Complaint *, void *user))                    \
    X(void *, N_VNew_Serial, (int64_t n, void *context))                                           \
    X(double *, N_VGetArrayPointer_Serial, (void *vector))                                         \
    X(void, N_VDestroy_Serial, (void *vector))                                                     \
    X(void *, SUNDenseMatrix, (int64_t rows, int64_t columns, void *context))                      \
    X(void, SUNMatDestroy, (void *matrix))                                                         \
    X(void *, SUNLinSol_Dense, (void *vector, void *matrix, void *context))                        \
    X(int, SUNLinSolFree, (void *solver))                                                          \
    X(void *, CVodeCreate, (int method, void *context))                                            \
    X(int, CVodeInit, (void *memory, Rates *, double t, void *states))                             \
    X(int, CVodeReInit, (void *memory, double t, void *states))                                    \
    X(int, CVodeSetUserData, (void *memory, void *user))                                           \
    X(int, CVodeSVtolerances, (void *memory, double relative, void *absolute))                     \
    X(int, CVodeRootInit, (void *memory, int n, Roots *))                                          \
    X(int, CVodeSetLinearSolver, (void *memory, void *solver, void *matrix))                       \
    X(int, CVodeSetNoInactiveRootWarn, (void *memory))                                             \
    X(int, CVodeSetStopTime, (void *memory, double t))                                             \
    X(int, CVodeSetMaxStep, (void *memory, double h))                                              \
    X(int, CVodeClearStopTime, (void *memory))                                                     \
    X(int, CVodeSetMaxNumSteps, (void *memory, long n))                                            \
    X(int, CVode, (void *memory, double t, void *states, double *reached, int task))               \
    X(void, CVodeFree, (void **memory))

#define CVODE_MEMBER(result, name, arguments) result(*name) arguments;

struct Cvode {
    CVODE_CALLS(CVODE_MEMBER)
};

#endif
