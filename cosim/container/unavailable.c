/* A container has no Model Exchange and declares no directional derivatives. */
#include "inside.h"

#define UNAVAILABLE(name, ...)                                                                     \
    Status name(Instance *x, __VA_ARGS__) { return instance_unavailable(x, __func__); }

UNAVAILABLE(exchange_update, bool *changed, bool *defined, double *next)
UNAVAILABLE(exchange_enter, Phase phase)
UNAVAILABLE(exchange_set_time, double time)
UNAVAILABLE(exchange_set_states, const double states[], size_t count)
UNAVAILABLE(exchange_get_states, double states[], size_t count)
UNAVAILABLE(exchange_get_derivatives, double derivatives[], size_t count)
UNAVAILABLE(exchange_get_nominals, double nominals[], size_t count)
UNAVAILABLE(exchange_get_indicators, double indicators[], size_t count)

Status slopes_multiply(Instance *x, Product product, Chosen unknowns, Chosen knowns,
                       const double seed[], double sensitivity[], const char *call) {
    return instance_unavailable(x, call);
}

size_t exchange_count(const Instance *x) { return 0; }

size_t exchange_indicator_count(const Instance *x) { return 0; }
