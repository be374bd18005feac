/* A container has no Model Exchange and declares no directional derivatives. */
#include "inside.h"

Status exchange_update(Instance *x, bool *defined, double *next) {
    return instance_unavailable(x, __func__);
}

Status exchange_enter(Instance *x, Phase phase) { return instance_unavailable(x, __func__); }

Status exchange_set_time(Instance *x, double time) { return instance_unavailable(x, __func__); }

size_t exchange_count(const Instance *x) { return 0; }

Status exchange_set_states(Instance *x, const double states[], size_t count) {
    return instance_unavailable(x, __func__);
}

Status exchange_get_states(Instance *x, double states[], size_t count) {
    return instance_unavailable(x, __func__);
}

Status exchange_get_derivatives(Instance *x, double derivatives[], size_t count) {
    return instance_unavailable(x, __func__);
}

Status exchange_get_nominals(Instance *x, double nominals[], size_t count) {
    return instance_unavailable(x, __func__);
}

Status slopes_multiply(Instance *x, Product product, Chosen unknowns, Chosen knowns,
                       const double seed[], double sensitivity[], const char *call) {
    return instance_unavailable(x, call);
}
