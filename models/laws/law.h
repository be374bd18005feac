/* What a friction law is: the force that opposes the velocity v [m/s] of a contact, positive for
 * v > 0, as a function of v and of the law's states.
 *
 * variables.h is generated from law.toml and, where a model contains the law, from model.toml:
 * `Law` has the law's parameters and `LawState` its states by name. A law touches no other member
 * of them, so that the same file serves every plant and every compensator.
 */
#ifndef LAW_H
#define LAW_H

#include "variables.h"

/* Friction force [N] now. */
double law_force(double v, const LawState *s, const Law *p);

/* Go h [s] ahead at constant v; returns the mean force [N] over the step. */
double law_step(double h, double v, LawState *s, const Law *p);

/* The same law where friction is `factor` times as large at every steady speed; its stiffness
 * stays. */
Law law_scaled(const Law *p, double factor);

#if LAW_IS_SMOOTH
/* Derivatives of the states by time. */
void law_rate(double v, const LawState *s, const Law *p, LawRate *rate);

/* Partial derivatives of the force and of the states' derivatives by v and by the states; J comes
 * zeroed. At v = 0, where |v| has a kink, the mean of those on either side. */
void law_jacobian(double v, const LawState *s, const Law *p, LawJacobian *J);
#endif

#endif
