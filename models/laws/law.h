/* What a friction law is: the force that opposes the velocity v [m/s] of a contact, positive for
 * v > 0, as a function of v and of the law's states.
 *
 * variables.h is generated from law.toml and, where a model contains the law, from model.toml:
 * `Law` has the law's parameters and `LawState` its states by name. A law touches no other member
 * of them, so that the same file serves every plant and every compensator. law_scaled(p, factor) is
 * the same law where friction is that times as large at every steady speed; its stiffness stays.
 */
#ifndef LAW_H
#define LAW_H

#include <stdbool.h>

#include "numerics/elementary.h"
#include "variables.h"

/* Friction force [N] now. */
double law_force(double v, const LawState *s, const Law *p);

/* Go h [s] ahead at constant v; returns the mean force [N] over the step. */
double law_step(double h, double v, LawState *s, const Law *p);

#if LAW_IS_SMOOTH
/* Derivatives of the states by time. */
void law_rate(double v, const LawState *s, const Law *p, LawRate *rate);

/* Partial derivatives of the force and of the states' derivatives by v and by the states; J comes
 * zeroed. At v = 0, where |v| has a kink, the mean of those on either side. */
void law_jacobian(double v, const LawState *s, const Law *p, LawJacobian *J);
#endif

#if LAW_SWITCHES
/* Model Exchange of a mass on a contact with modes. Modes change in law_switch alone, so that the
 * other two are smooth in each mode, a little beyond its end as well. u [N] is the force on the
 * mass without that of the contact. */

/* Added to an indicator, so that at the edge of its mode it is not 0. */
static const double LAW_EDGE = 1e-300;

/* Friction force [N], and derivatives of the states by time. */
double law_flow(double v, double u, const LawState *s, const Law *p, LawRate *rate);

/* Event indicators: one below 0 is a mode that does not hold any more. */
void law_events(double v, double u, const LawState *s, const Law *p, LawEvents *z);

/* Set the modes so that none is; returns whether v or a state with a derivative was set as well. */
bool law_switch(double *v, double u, LawState *s, const Law *p);
#endif

#endif
