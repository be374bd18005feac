/* What a model is, to the adapter: structs and functions. It knows no FMI.
 *
 * variables.h is generated from model.toml: structs Inputs, States, Derivatives, Memory, Outputs,
 * Indicators, Parameters of doubles, in the order of the file (a role without variables is an
 * incomplete type; modes are the last States), and Jacobian, whose dx.v.u.F is the partial
 * derivative of dv/dt by input F. Units are SI. `const` says what a function may not change.
 * Nothing is allocated or kept.
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

/* A model whose states have derivatives in model.toml has this one as well. */

/* The equations without steps: dx/dt and outputs at time t. */
void model_continuous(double t, const States *x, const Inputs *u, const Parameters *p,
                      Derivatives *dx, Outputs *y);

/* Without event indicators it has its Jacobian:
 * partial derivatives of model_continuous where w is NULL, else of model_outputs; J comes zeroed.
 */
void model_jacobian(double t, const States *x, const Memory *w, const Inputs *u,
                    const Parameters *p, Jacobian *J);

/* With event indicators it has modes, and these two: model_continuous is smooth in each mode.
 * Indicators are above 0 as long as the modes hold. */
void model_events(double t, const States *x, const Inputs *u, const Parameters *p, Indicators *z);

/* Bring the modes to the states and inputs; returns whether a state with a derivative was set. */
bool model_switch(double t, States *x, const Inputs *u, const Parameters *p);

/* A model that is `sampled` in model.toml has this one: take the samples that are due at time t;
 * returns the time of the next. Where too many are due it takes none, and returns a time that is
 * past. */
double model_sample(double t, Memory *w, const Inputs *u, const Parameters *p);

#endif
