/* Products with the matrix of partial derivatives of derivatives and outputs by states and inputs,
 * at the present values: those that FMI calls directional and adjoint derivatives. */
#ifndef SLOPES_H
#define SLOPES_H

#include "instance.h"

/* Variables by value reference. */
typedef struct {
    const uint32_t *references;
    size_t count;
} Chosen;

/* DIRECTIONAL: sensitivity[k] = sum over l of d unknown k / d known l * seed[l].
 * ADJOINT: sensitivity[l] = sum over k of seed[k] * d unknown k / d known l. */
typedef enum { DIRECTIONAL, ADJOINT } Product;

Status slopes_multiply(Instance *instance, Product product, Chosen unknowns, Chosen knowns,
                       const double seed[], double sensitivity[], const char *call);

#endif
