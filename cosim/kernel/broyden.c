#include "coupling.h"
#include <math.h>

static void swap_rows(int64_t n, double *a, double *b) {
    for (int64_t j = 0; j < n; j++) {
        const double x = a[j];
        a[j] = b[j];
        b[j] = x;
    }
}

/* Gauss and Jordan with the greatest pivot of each column; destroys the matrix. */
bool invert(int64_t n, double *matrix, double *inverse) {
    for (int64_t i = 0; i < n * n; i++) {
        inverse[i] = i % (n + 1) == 0;
    }
    for (int64_t k = 0; k < n; k++) {
        int64_t p = k;
        for (int64_t i = k + 1; i < n; i++) {
            p = fabs(matrix[i * n + k]) > fabs(matrix[p * n + k]) ? i : p;
        }
        swap_rows(n, matrix + k * n, matrix + p * n);
        swap_rows(n, inverse + k * n, inverse + p * n);
        const double pivot = matrix[k * n + k];
        if (!(fabs(pivot) > 0.0)) {
            return false;
        }
        for (int64_t j = 0; j < n; j++) {
            matrix[k * n + j] /= pivot;
            inverse[k * n + j] /= pivot;
        }
        for (int64_t i = 0; i < n; i++) {
            const double share = i == k ? 0.0 : matrix[i * n + k];
            for (int64_t j = 0; share != 0.0 && j < n; j++) {
                matrix[i * n + j] -= share * matrix[k * n + j];
                inverse[i * n + j] -= share * inverse[k * n + j];
            }
        }
    }
    return true;
}

/* Broyden's rule for the inverse B: B += (dw - B dr) (dw' B) / (dw' B dr). */
void update_inverse(int64_t n, double *inverse, const double *dw, const double *dr, double *work) {
    double *row = work, *error = work + n, scale = 0.0, length = 0.0;
    for (int64_t j = 0; j < n; j++) {
        row[j] = 0.0;
        for (int64_t i = 0; i < n; i++) {
            row[j] += dw[i] * inverse[i * n + j];
        }
        scale += row[j] * dr[j];
        length += dw[j] * dw[j];
    }
    if (!(fabs(scale) > 1e-6 * length)) {
        return; /* it would make the inverse singular */
    }
    for (int64_t i = 0; i < n; i++) {
        error[i] = dw[i];
        for (int64_t j = 0; j < n; j++) {
            error[i] -= inverse[i * n + j] * dr[j];
        }
    }
    for (int64_t i = 0; i < n * n; i++) {
        inverse[i] += error[i / n] * row[i % n] / scale;
    }
}
