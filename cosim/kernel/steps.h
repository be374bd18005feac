/* Steps components one after the other, led by the table of components. In place of this file,
 * kernel/__init__.py writes one for a certain system. */
#ifndef COSIM_STEPS_H
#define COSIM_STEPS_H

#include "walk.h"

/* Where components share a call instruction, the processor keeps guessing wrong which FMU it leads
 * to, and a step costs up to twice as much. So code is written out for several components. Within
 * one function the compiler lets calls share an instruction again, so each is kept apart. */
#define APART __attribute__((noinline)) static

/* n components of one version, all with inputs and outputs. The compiler knows both numbers. */
INLINE bool step_in_turn(Run *run, const Component *c, const double *now, double *next, int n,
                         int version) {
#pragma clang loop unroll(full)
    for (int i = 0; i < n; i++) {
        TRY(set_some_inputs(run, c + i, version, now) && do_step(run, c + i, version) &&
            get_some_outputs(run, c + i, version, c[i].n_outputs, next));
    }
    return true;
}

/* With all inputs from this point in time the order is free, and calls overlap in the processor. */
INLINE bool step_at_once(Run *run, const Component *c, const double *now, double *next, int n,
                         int version) {
#pragma clang loop unroll(full)
    for (int i = 0; i < n; i++)
        TRY(set_some_inputs(run, c + i, version, now));
    plain(true);
#pragma clang loop unroll(full)
    for (int i = 0; i < n; i++)
        TRY(do_step(run, c + i, version));
#pragma clang loop unroll(full)
    for (int i = 0; i < n; i++)
        TRY(get_some_outputs(run, c + i, version, c[i].n_outputs, next));
    return true;
}

/* The same for any components. */
#define NEXT(c, end, action)                                                                       \
    TRY(action);                                                                                   \
    if (++c == end) {                                                                              \
        break;                                                                                     \
    }
#define ALL_IN_TURN(c, begin, end, action)                                                         \
    for (const Component *c = begin; c != end;) {                                                  \
        NEXT(c, end, action);                                                                      \
        NEXT(c, end, action);                                                                      \
        NEXT(c, end, action);                                                                      \
        NEXT(c, end, action);                                                                      \
    }

APART bool step_any_in_turn(Run *run, const Component *begin, const Component *end,
                            const double *now, double *next) {
    ALL_IN_TURN(c, begin, end,
                set_inputs(run, c, now) && do_step(run, c, c->version) &&
                    get_outputs(run, c, c->n_outputs, next));
    return true;
}

APART bool step_any_at_once(Run *run, const Component *begin, const Component *end,
                            const double *now, double *next) {
    ALL_IN_TURN(c, begin, end, set_inputs(run, c, now));
    ALL_IN_TURN(c, begin, end, do_step(run, c, c->version));
    ALL_IN_TURN(c, begin, end, get_outputs(run, c, c->n_outputs, next));
    return true;
}

/* Many go in groups, whose memory stays in the nearest cache from one call to the next. Twelve lets
 * rings of two, three, four or six models meet the same call instructions in each group. */
enum { GROUP = 12 };

#define GROUPS(how)                                                                                \
    APART bool group_##how##_2(Run *run, const Component *c, const double *now, double *next) {    \
        return step_##how(run, c, now, next, GROUP, 2);                                            \
    }                                                                                              \
    APART bool group_##how##_3(Run *run, const Component *c, const double *now, double *next) {    \
        return step_##how(run, c, now, next, GROUP, 3);                                            \
    }                                                                                              \
    INLINE bool step_all_##how(Run *run, const double *now, double *next, int version) {           \
        const Component *c = run->components, *end = c + run->n_components;                        \
        for (; end - c > GROUP; c += GROUP) {                                                      \
            TRY(version == 2   ? group_##how##_2(run, c, now, next)                                \
                : version == 3 ? group_##how##_3(run, c, now, next)                                \
                               : step_any_##how(run, c, c + GROUP, now, next));                    \
        }                                                                                          \
        return c == end || step_any_##how(run, c, end, now, next);                                 \
    }
GROUPS(in_turn)
GROUPS(at_once)

#define WALK(name, ...)                                                                            \
    INLINE bool step_##name(Run *run, const double *now, double *next) { return __VA_ARGS__; }     \
    APART bool walk_##name(Run *run, int64_t end) {                                                \
        return walk(run, end, step_##name, run->width, run->constant_step);                        \
    }
#define WALKS(how)                                                                                 \
    WALK(mixed_##how, step_all_##how(run, now, next, 0))                                           \
    WALK(fmi2_##how, step_all_##how(run, now, next, 2))                                            \
    WALK(fmi3_##how, step_all_##how(run, now, next, 3))
WALKS(in_turn)
WALKS(at_once)

/* A few need not even be counted. */
#define FEW(X) X(1) X(2) X(3) X(4) X(5) X(6)
#define WALKS_OF(n)                                                                                \
    WALK(in_turn_##n##_2, step_in_turn(run, run->components, now, next, n, 2))                     \
    WALK(in_turn_##n##_3, step_in_turn(run, run->components, now, next, n, 3))                     \
    WALK(at_once_##n##_2, step_at_once(run, run->components, now, next, n, 2))                     \
    WALK(at_once_##n##_3, step_at_once(run, run->components, now, next, n, 3))
FEW(WALKS_OF)

static bool step_until(Run *run, int64_t end) {
    typedef bool Walk(Run *, int64_t);
#define ENTRY(n)                                                                                   \
    {{walk_in_turn_##n##_2, walk_in_turn_##n##_3}, {walk_at_once_##n##_2, walk_at_once_##n##_3}},
    static Walk *const few[][2][2] = {FEW(ENTRY)};
    static Walk *const many[][3] = {{walk_mixed_in_turn, walk_fmi2_in_turn, walk_fmi3_in_turn},
                                    {walk_mixed_at_once, walk_fmi2_at_once, walk_fmi3_at_once}};
    const int64_t n = run->n_components, version = run->uniform, jacobi = run->jacobi != 0;
    if (version && n <= (int64_t)(sizeof few / sizeof *few))
        return few[n - 1][jacobi][version - 2](run, end);
    return many[jacobi][version ? version - 1 : 0](run, end);
}

#endif
