#include "instance.h"

#if HAS_SLOPES
#include "model.h"

/* Rows: derivatives, then outputs. Columns: states, then inputs. */
enum { COLUMNS = STATES_COUNT + INPUTS_COUNT, ROWS = DERIVATIVES_COUNT + OUTPUTS_COUNT };
typedef union {
    Jacobian named;
    double at[ROWS][COLUMNS];
} Matrix;

static bool lies(uint32_t reference, uint32_t first, uint32_t count) {
    return reference >= first && reference - first < count;
}

static bool is_known(uint32_t r) {
    return lies(r, STATES_AT, STATES_COUNT) || lies(r, INPUTS_AT, INPUTS_COUNT);
}

/* A state may be an output as well. */
static bool is_unknown(uint32_t r) {
    return lies(r, STATES_AT, STATES_COUNT) || lies(r, DERIVATIVES_AT, DERIVATIVES_COUNT) ||
           lies(r, OUTPUTS_AT, OUTPUTS_COUNT);
}

static double slope(const Matrix *matrix, uint32_t unknown, uint32_t known) {
    if (lies(unknown, STATES_AT, STATES_COUNT))
        return unknown == known ? 1.0 : 0.0;
    const uint32_t row = lies(unknown, OUTPUTS_AT, OUTPUTS_COUNT)
                             ? DERIVATIVES_COUNT + unknown - OUTPUTS_AT
                             : unknown - DERIVATIVES_AT;
    return matrix->at[row][lies(known, STATES_AT, STATES_COUNT) ? known - STATES_AT
                                                                : STATES_COUNT + known - INPUTS_AT];
}

static Status require(Instance *i, Chosen chosen, bool (*fits)(uint32_t), const char *what,
                      const char *call) {
    for (size_t k = 0; k < chosen.count; k++)
        if (!fits(chosen.references[k]))
            return instance_report(i, ERROR, "logStatusError", "%s: value reference %lu is not %s",
                                   call, (unsigned long)chosen.references[k], what);
    return OK;
}

Status slopes_multiply(Instance *i, Product product, Chosen unknowns, Chosen knowns,
                       const double seed[], double sensitivity[], const char *call) {
    if (require(i, unknowns, is_unknown, "a derivative or an output", call) != OK ||
        require(i, knowns, is_known, "a continuous state or an input", call) != OK)
        return ERROR;
    const double *values = i->now.values;
    const Memory *memory = (const Memory *)(values + MEMORY_AT);
    Matrix matrix = {0};
    instance_refresh(i);
    model_jacobian(values[0], (const States *)(values + STATES_AT),
                   i->model_exchange ? NULL : memory, (const Inputs *)(values + INPUTS_AT),
                   (const Parameters *)(values + PARAMETERS_AT), &matrix.named);
    const size_t results = product == DIRECTIONAL ? unknowns.count : knowns.count;
    for (size_t k = 0; k < results; k++)
        sensitivity[k] = 0.0;
    for (size_t k = 0; k < unknowns.count; k++)
        for (size_t l = 0; l < knowns.count; l++) {
            const double by = slope(&matrix, unknowns.references[k], knowns.references[l]);
            if (product == DIRECTIONAL)
                sensitivity[k] += by * seed[l];
            else
                sensitivity[l] += seed[k] * by;
        }
    return OK;
}
#else
Status slopes_multiply(Instance *i, Product product, Chosen unknowns, Chosen knowns,
                       const double seed[], double sensitivity[], const char *call) {
    return instance_unavailable(i, call);
}
#endif
