#include "numerics/elementary.h"
#include "variables.h"

/* A row of weights for each hidden unit: of velocity, displacement and 1, and that of its output */
enum { UNITS = 8 };

/* Largest weight of an input that is learned: beyond it a unit only switches */
static const double STEEPEST = 20.0;

static double hidden(const double *w, const double *place) {
    return 1.0 - 2.0 / (elementary_exp(2.0 * (w[0] * place[0] + w[1] * place[1] + w[2])) + 1.0);
}

static double force_of(const Memory *w, const double *place, const Parameters *p) {
    double sum = 0.0;
    for (int i = 0; i < UNITS; i++)
        sum += w->w[i][3] * hidden(w->w[i], place);
    return p->F_max * sum;
}

/* One step along the gradient, of the length that takes away the share gamma of the error. */
static void learn(Memory *w, const double *place, double error, const Parameters *p) {
    double output[UNITS], slope[UNITS], square = 0.0;
    const double inputs = 1.0 + place[0] * place[0] + place[1] * place[1];
    for (int i = 0; i < UNITS; i++) {
        output[i] = hidden(w->w[i], place);
        slope[i] = w->w[i][3] * (1.0 - output[i] * output[i]);
        square += output[i] * output[i] + slope[i] * slope[i] * inputs;
    }
    if (square == 0.0)
        return; /* all weights are 0 */
    const double step = p->gamma * error / (p->F_max * square);
    for (int i = 0; i < UNITS; i++) {
        double *row = w->w[i];
        for (int j = 0; j < 2; j++)
            row[j] = limited(row[j] + step * slope[i] * place[j], STEEPEST);
        row[2] = limited(row[2] + step * slope[i], STEEPEST);
        row[3] = limited(row[3] + step * output[i], 1.0);
    }
}

#include "numerics/network.h"

void model_start(double t, States *x, Memory *w, const Inputs *u, const Parameters *p) {
    *w = (Memory){.k = first_sample(t, p->T_s), .v_last = u->v_r};
    for (int i = 0; i < UNITS; i++)
        for (int j = 0; j < 4; j++)
            w->w[i][j] = p->w_0[i][j];
}
