/* A step of components whose inputs follow polynomials, with loops among them. */
#include "calls.h"
#include "coupling.h"
#include <string.h>

Polynomial hold(const Run *run, int64_t column, bool fresh, double t, double h, int64_t degree) {
    const Coupling *k = run->coupling;
    const double f0 = k->past[column];
    if (degree == 0)
        return (Polynomial){{fresh ? k->next[column] : f0}};
    double s[MAX_DEGREE], slope[MAX_DEGREE] = {0.0}; /* from (0, f0) to the other points */
    int64_t n = 0;
    if (fresh) {
        s[0] = h;
        slope[n++] = (k->next[column] - f0) / h;
    }
    for (int64_t i = 1; n < degree && i < k->n_past; i++, n++) {
        s[n] = k->times[i] - t;
        slope[n] = (k->past[i * run->width + column] - f0) / s[n];
    }
    const double a2 = n < 2 ? 0.0 : (slope[0] - slope[1]) / (s[0] - s[1]);
    const double a1 = n < 2 ? slope[0] : slope[0] - a2 * s[0];
    return (Polynomial){{f0, a1, a2}};
}

double value_at(Polynomial p, double s) { return p.a[0] + s * (p.a[1] + s * p.a[2]); }

double mean_over(Polynomial p, double h) { return p.a[0] + h * (p.a[1] / 2.0 + h * p.a[2] / 3.0); }

/* The share of a step in which inputs of FMUs that do not interpolate are at their end already, so
 * that outputs show it. */
static const double END = 0.125;

/* The part of a step for which inputs are set. */
enum Part { WHOLE, FIRST_PART, LAST_PART };

/* One value for a part of the step. Those of beginning and end have the mean of the whole. */
static double held(Polynomial p, const Link *link, enum Part part, double h) {
    switch (part) {
    case FIRST_PART:
        return (mean_over(p, h) - END * value_at(p, h)) / (1.0 - END);
    case LAST_PART:
        return value_at(p, h);
    default:
        return link->feeds_through ? value_at(p, h) : mean_over(p, h);
    }
}

/* In the unit of input i. */
static Polynomial scaled(Polynomial p, const Component *c, size_t i) {
    if (c->scales) {
        for (int j = 0; j <= MAX_DEGREE; j++)
            p.a[j] *= c->scales[i];
        p.a[0] += c->scales[c->n_inputs + i];
    }
    return p;
}

static Polynomial followed(const Run *run, const Link *link, double t, double h) {
    if (link->holds) {
        const Coupling *k = run->coupling;
        return (Polynomial){{(link->fresh ? k->next : k->past)[link->column]}};
    }
    return hold(run, link->column, link->fresh, t, h, run->coupling->degree);
}

static bool set_held_inputs(Run *run, int64_t index, double t, double h, enum Part part) {
    const Coupling *k = run->coupling;
    const Component *c = &run->components[index];
    const Member *m = &k->members[index];
    const size_t n = c->n_inputs;
    for (size_t i = 0; i < n; i++) {
        const Link *link = &m->links[i];
        const Polynomial p = scaled(followed(run, link, t, h), c, i);
        m->values[i] = m->interpolates ? p.a[0] : held(p, link, part, h);
        for (size_t j = 0; m->interpolates && j < (size_t)k->degree; j++)
            m->derivatives[j * n + i] = (double)(j + 1) * p.a[j + 1]; /* 1 a1, 2 a2 */
    }
    if (n == 0)
        return true;
    TRY(plain(set(run, c, c->version, c->input_references, n, m->values)));
    if (!m->interpolates)
        return true;
    MARK(c, "fmi2SetRealInputDerivatives");
    return passed(run, c, "fmi2SetRealInputDerivatives",
                  (int)m->set_derivatives(c->instance, m->derivative_references,
                                          n * (size_t)k->degree, m->derivative_orders,
                                          m->derivatives));
}

static bool step_member(Run *run, int64_t i, double t, double h, bool final) {
    const Component *c = &run->components[i];
    if (!run->coupling->members[i].splits) {
        return set_held_inputs(run, i, t, h, WHOLE) &&
               do_step_over(run, c, c->version, t, h, final);
    }
    const double late = t + (1.0 - END) * h;
    return set_held_inputs(run, i, t, h, FIRST_PART) &&
           do_step_over(run, c, c->version, t, late - t, final) &&
           set_held_inputs(run, i, t, h, LAST_PART) &&
           do_step_over(run, c, c->version, late, t + h - late, final);
}

/* Once through the components of a loop, or the one that is in none. */
static bool sweep(Run *run, Loop *loop) {
    Coupling *k = run->coupling;
    if (k->swept && !restore(run, loop->first, loop->end))
        return false;
    k->swept = true;
    k->sweeps++;
    for (int64_t i = loop->first; i < loop->end; i++) {
        const Component *c = &run->components[i];
        const double h = (double)k->members[i].every * k->h;
        TRY(step_member(run, i, k->t, h, !loop->rollback) &&
            get_outputs(run, c, c->n_outputs, k->next));
    }
    return true;
}

bool attempt(Run *run, double t, double h) {
    Coupling *k = run->coupling;
    k->t = t;
    k->h = h;
    k->steps++;
    for (int64_t i = 0; i < k->n_loops; i++) {
        Loop *loop = &k->loops[i];
        if (run->done % k->members[loop->first].every)
            continue; /* it has stepped beyond this point already */
        k->swept = false;
        for (int64_t j = 0; j < loop->n; j++) {
            const int64_t column = loop->columns[j];
            k->next[column] = value_at(hold(run, column, false, t, h, k->degree), h);
        }
        if ((loop->rollback && !save(run, loop->first, loop->end)) ||
            !(loop->n ? solve(run, loop, k->next, sweep) : sweep(run, loop))) {
            return false;
        }
    }
    return true;
}

/* Where a signal jumps, at the end of a step, its past does so too: no polynomial goes through the
 * jump. */
static void carry_past(Run *run, const double *row) {
    const Coupling *k = run->coupling;
    for (int64_t i = 0; i < run->n_external; i++) {
        const double left = k->next[i];
        for (int64_t j = 0; row[i] != left && j < k->n_past; j++) {
            double *past = &k->past[j * run->width + i];
            *past = row[i] + (*past - left);
        }
    }
}

void keep(Run *run, const double *row, double t) {
    Coupling *k = run->coupling;
    const size_t width = (size_t)run->width;
    carry_past(run, row);
    memmove(k->past + width, k->past, (MAX_PAST - 1) * width * sizeof *row);
    memmove(k->times + 1, k->times, (MAX_PAST - 1) * sizeof *k->times);
    memcpy(k->past, row, width * sizeof *row);
    k->times[0] = t;
    k->n_past += k->n_past < MAX_PAST;
}

bool begin_coupled(Run *run) {
    Coupling *k = run->coupling;
    k->n_past = k->steps = k->sweeps = k->rejected = 0;
    k->inner = run->step;
    memcpy(k->next, run->rows, (size_t)run->width * sizeof *k->next);
    keep(run, run->rows, run->start);
    for (int64_t i = 0; i < k->n_loops; i++)
        k->loops[i].known = false; /* so that a run depends on nothing before it */
    for (int64_t i = 0; i < k->n_members; i++)
        k->members[i].proven = false;
    return true;
}
