/* What a model is, to the adapter: structs and functions. It knows no FMI.
 *
 * variables.h is generated from model.toml: structs Inputs, States, Derivatives, Memory, Outputs,
 * Parameters of doubles, in the order of the file (a role without variables is an incomplete type),
 * and Jacobian, whose dx.v.u.F is the partial derivative of dv/dt by input F.
 * Units are SI. `const` says what a function may not change. Nothing is allocated or kept.
 *
 * Order of calls: model_start once after the parameters are set, then model_step for each
 * communication step; model_outputs after either.
 */
#ifndef MODEL_H
#define MODEL_H

#include <stdbool.h>

#include "variables.h"

/* Bring the memory (and, where it follows from the parameters, the state) to time t. */
void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p);

/* Go from t to t + h with the inputs held. Returns false when the result would not be finite,
 * or when the step is so long that it would take minutes. */
bool model_step(double t, double h, States *x, Memory *w, const Inputs *u, const Parameters *p);

/* Outputs at time t. */
void model_outputs(double t, const States *x, const Memory *w, const Inputs *u, const Parameters *p,
                   Outputs *y);

/* A model whose states have derivatives in model.toml has these two as well. */

/* The equations without steps: dx/dt and outputs at time t. */
void model_continuous(double t, const States *x, const Inputs *u, const Parameters *p,
                      Derivatives *dx, Outputs *y);

/* Partial derivatives of model_continuous where w is NULL, else of model_outputs; J comes zeroed.
 */
void model_jacobian(double t, const States *x, const Memory *w, const Inputs *u,
                    const Parameters *p, Jacobian *J);

/* A model that is `sampled` in model.toml has this one: take the samples that are due at time t;
 * returns the time of the next. Where too many are due it takes none, and returns a time that is
 * past. */
double model_sample(double t, Memory *w, const Inputs *u, const Parameters *p);

#endif
