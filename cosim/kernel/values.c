/* Values on the general path: doubles on the kernel's side, any type on the FMU's. */
#include "general_path.h"
#include <math.h>

fmi2Status transfer(GeneralComponent *f, const Group *g) {
    int status;
    MARK_CALL(g->name);
    if (f->version == 2) {
        status = ((int (*)(void *, const uint32_t *, size_t, void *))g->call)(
            f->instance, g->references, g->n, g->values);
    } else if (g->sizes) {
        status =
            ((int (*)(void *, const uint32_t *, size_t, const size_t *, void *, size_t))g->call)(
                f->instance, g->references, g->n, g->sizes, g->values, g->n_values);
    } else {
        status = ((int (*)(void *, const uint32_t *, size_t, void *, size_t))g->call)(
            f->instance, g->references, g->n, g->values, g->n_values);
    }
    return noted(f, g->name, status);
}

fmi2Status set_groups(GeneralComponent *f, const Groups *groups) {
    for (size_t i = 0; i < groups->n; i++)
        TRY_STATUS(groups->groups[i].clock ? fmi2OK : transfer(f, &groups->groups[i]));
    return fmi2OK;
}

/* Numbers beyond a type's range are held at its ends; the value is known to be finite. The ends of
 * 64 bits are no doubles: they round to powers of two beyond. */
static int64_t to_INT64(double value) { return value >= 0x1p63 ? INT64_MAX : (int64_t)value; }
static uint64_t to_UINT64(double value) { return value >= 0x1p64 ? UINT64_MAX : (uint64_t)value; }

#define STORE(place_, type)                                                                        \
    case place_:                                                                                   \
        ((type *)g->values)[place] = place_ == INT64    ? (type)to_INT64(value)                    \
                                     : place_ == UINT64 ? (type)to_UINT64(value)                   \
                                                        : (type)value;                             \
        break;
void store(const Group *g, int64_t place, double value) {
    static const double lowest[] = {
        [INT8] = INT8_MIN, [INT16] = INT16_MIN, [INT32] = INT32_MIN, [INT64] = -0x1p63, [TEXT] = 0};
    static const double highest[] = {
        [INT8] = INT8_MAX,     [UINT8] = UINT8_MAX, [INT16] = INT16_MAX,
        [UINT16] = UINT16_MAX, [INT32] = INT32_MAX, [UINT32] = UINT32_MAX,
        [INT64] = 0x1p63,      [UINT64] = 0x1p64,   [TRUTH] = 1};
    if (g->stored > FLOAT32 && g->stored < TRUTH)
        value = fmax(lowest[g->stored], fmin(highest[g->stored], value));
    switch (g->stored) { STORED_TYPES(STORE) }
}

#define LOAD(place_, type)                                                                         \
    case place_:                                                                                   \
        return (double)((const type *)g->values)[place];
static double load(const Group *g, int64_t place) {
    switch (g->stored) { STORED_TYPES(LOAD) }
    return NAN;
}

/* Take values for the next step; where the FMU is given them at once, they lie ready in the groups.
 * Whether one is an event. */
bool take_values(GeneralComponent *f, const uint32_t r[], size_t n, const double values[]) {
    bool event = false;
    for (size_t i = 0; i < n; i++) {
        const Port *port = &f->input_ports[r[i]];
        const Group *group = &f->inputs.groups[port->group];
        event = event || is_event(group, f->after[r[i]], values[i]);
        f->after[r[i]] = values[i];
        if (!f->running || !f->model_exchange) {
            /* Where the first step takes this value again, a clock does not tick before it. */
            const bool later = group->clock && !f->running && !port->ahead;
            f->before[r[i]] = values[i];
            store(group, port->place, later ? 0.0 : values[i]);
        }
    }
    return event;
}

fmi2Status set_taken(GeneralComponent *f) {
    for (size_t i = 0; i < f->inputs.n; i++) {
        const Group *group = &f->inputs.groups[i];
        if (!group->clock && !(f->running && f->event_mode && group->discrete))
            TRY_STATUS(transfer(f, group));
    }
    return fmi2OK;
}

fmi2Status get_values(GeneralComponent *f, const uint32_t r[], size_t n, double values[]) {
    TRY_STATUS(set_groups(f, &f->outputs));
    for (size_t i = 0; i < n; i++) {
        const Port *port = &f->output_ports[r[i]];
        values[i] = load(&f->outputs.groups[port->group], port->place);
    }
    return fmi2OK;
}
