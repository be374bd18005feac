/* The velocity that a loop without friction reaches under its commands, for models with the
 * variables of command.toml. */
#ifndef COMMAND_H
#define COMMAND_H

#include "numerics/linear.h"
#include "variables.h"

/* Take a sample. Returns the mean velocity of the period that begins, `lead` ahead [m/s]. */
static inline double expected_velocity(Memory *w, const Inputs *u, const Parameters *p) {
    const double way = u->x_cmd - w->x_last, before = w->v_last;
    for (int i = 0; i < LOOP_ORDER; i++)
        w->loop_x[i] += p->loop_G[i] * way;
    w->x_last = u->x_cmd;
    linear_step(w->loop_x, p->loop_A, p->loop_B, u->v_cmd, p->loop_E, u->a_cmd);
    w->v_last = linear_output(p->loop_C, w->loop_x) + p->loop_D * u->v_cmd;
    w->v_held = w->v_last;
    const double slope = (w->v_last - before) / p->T_s; /* [m/s2] */
    return 0.5 * (before + w->v_last) + p->lead * slope;
}

#endif
