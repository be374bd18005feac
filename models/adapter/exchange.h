/* Model Exchange over an instance: the tool's solver moves time and states. */
#ifndef EXCHANGE_H
#define EXCHANGE_H

#include "instance.h"

/* Take what is due now. *defined: whether there is a next event, whose time is then *next. */
Status exchange_update(Instance *instance, bool *defined, double *next);

/* Go from event mode to continuous-time mode or back. */
Status exchange_enter(Instance *instance, Phase phase);

Status exchange_set_time(Instance *instance, double time);

/* A value for each of the model's states, else ERROR. DISCARD: not finite there, so the solver must
 * take a smaller step. */
Status exchange_set_states(Instance *instance, const double states[], size_t count);
Status exchange_get_states(Instance *instance, double states[], size_t count);
Status exchange_get_derivatives(Instance *instance, double derivatives[], size_t count);
Status exchange_get_nominals(Instance *instance, double nominals[], size_t count);

#endif
