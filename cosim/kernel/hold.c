/* What inputs do between communication points: a polynomial through the last known ones. */
#include "coupling.h"

Polynomial hold(const Run *run, int64_t column, bool fresh, double t, double h) {
    const Coupling *k = run->coupling;
    const double f0 = k->past[column];
    if (k->degree == 0) {
        return (Polynomial){{fresh ? k->next[column] : f0}};
    }
    double s[MAX_DEGREE], slope[MAX_DEGREE] = {0.0}; /* from (0, f0) to the other points */
    int64_t n = 0;
    if (fresh) {
        s[0] = h;
        slope[n++] = (k->next[column] - f0) / h;
    }
    for (int64_t i = 1; n < k->degree && i < k->n_past; i++, n++) {
        s[n] = k->times[i] - t;
        slope[n] = (k->past[i * run->width + column] - f0) / s[n];
    }
    const double a2 = n < 2 ? 0.0 : (slope[0] - slope[1]) / (s[0] - s[1]);
    const double a1 = n < 2 ? slope[0] : slope[0] - a2 * s[0];
    return (Polynomial){{f0, a1, a2}};
}

double value_at(Polynomial p, double s) { return p.a[0] + s * (p.a[1] + s * p.a[2]); }

double mean_over(Polynomial p, double h) { return p.a[0] + h * (p.a[1] / 2.0 + h * p.a[2] / 3.0); }
