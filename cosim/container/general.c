/* Components on the general path of the kernel: other types than doubles, arrays, event mode. */
#include "inside.h"
#include "library.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

#if !GENERAL /* no component is; the kernel's general path is left out */
const char *general_load(Instance *x, int part) { return NULL; }
void general_unload(Instance *x, int part) {}
int general_put(Instance *x, int part, void (*set)(void), uint32_t reference, void *value) {
    return ERROR;
}
void general_tighten(Instance *x, int part) {}
#else

#define TAKE_GENERAL(name) c->call.fmi2.name = general_##name;
#define ROW(place, fmi2, fmi3, reasons) {{fmi2, fmi3}, reasons},

/* The groups of an instance: their functions, and room for their values. */
static const char *fill(Groups *groups, const Groups *of, void *library) {
    groups->groups = calloc(of->n + 1, sizeof *groups->groups);
    for (size_t i = 0; groups->groups && i < of->n; i++) {
        Group *g = &groups->groups[i];
        *g = of->groups[i];
        g->call = library_function(library, g->name);
        g->values = calloc(g->n_values + 1, sizeof(double));
        if (!g->call || !g->values) {
            return g->name;
        }
        for (size_t j = 0; j < g->n_values; j++) {
            store(g, (int64_t)j, ((const double *)of->groups[i].values)[j]);
        }
    }
    return groups->groups ? NULL : "calloc";
}

const char *general_load(Instance *x, int part) {
    static const struct {
        const char *names[2], *reasons;
    } calls[] = {GENERAL_CALLS(ROW)};
    Component *c = &x->components[part];
    GeneralComponent *f = &x->general[part];
    void *library = x->access[part].library;
    const GeneralComponent *of = PARTS[part].general;
    FMI2_CALLS(TAKE_GENERAL)
    access_load_values(&x->access[part], (int)of->version);
    *f = *of;
    f->clocks = NULL;
    f->inputs.groups = f->outputs.groups = NULL;
    c->log = &f->log;
    for (int i = 0; i < N_CALLS; i++) {
        const char *name = calls[i].names[of->version - 2], *why = calls[i].reasons;
        const bool needed = strchr(why, of->model_exchange ? 'M' : 'C') ||
                            (of->event_mode && strchr(why, 'E')) ||
                            (of->n_clocks && strchr(why, 'K'));
        f->call[i] = needed && *name != '-' ? library_function(library, name) : NULL;
        if (needed && *name != '-' && !f->call[i]) {
            return name;
        }
    }
    f->cvode = &x->cvode;
    f->before = calloc(4 * of->n_inputs + 1, sizeof *f->before);
    f->after = f->before + of->n_inputs;
    f->rates = f->after + of->n_inputs;
    f->courses = calloc(of->n_inputs + 1, sizeof *f->courses);
    f->clocks = calloc(of->n_clocks + 1, sizeof *f->clocks);
    if (!f->before || !f->courses || !f->clocks) {
        return "calloc";
    }
    memcpy(f->clocks, of->clocks, of->n_clocks * sizeof *f->clocks);
    const char *missing = fill(&f->inputs, &of->inputs, library);
    const char *too = fill(&f->outputs, &of->outputs, library);
    return missing ? missing : too;
}

static void empty(Groups *groups) {
    for (size_t i = 0; groups->groups && i < groups->n; i++) {
        free(groups->groups[i].values);
    }
    free(groups->groups);
}

void general_unload(Instance *x, int part) {
    GeneralComponent *f = &x->general[part];
    free(f->before);
    free((void *)f->courses);
    free(f->clocks);
    empty(&f->inputs);
    empty(&f->outputs);
}

/* As GeneralComponent.tighten does; without a stop time for the longest run. */
void general_tighten(Instance *x, int part) {
    const double usual = PARTS[part].general->tolerance, n = (x->run.stop - x->run.start) / STEP;
    const double share = 0.1 / fmax(1.0, round(n));
    x->general[part].tolerance = fmin(usual, fmax(1e-10, share * usual));
}

int general_put(Instance *x, int part, void (*set)(void), uint32_t reference, void *value) {
    const Group group = {
        .call = set,
        .name = "setting a parameter",
        .n = 1,
        .references = &reference,
        .n_values = 1,
        .values = value,
    };
    return (int)general_tune(&x->general[part], NULL, 0, &group);
}
#endif
