/* Vectors of LANES numbers, for C that models/lanes/translation.py has translated. A mask is -1 in
 * the lanes that take part, else 0. */
#ifndef LANES_H
#define LANES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef LANES
#define LANES 8
#endif

typedef double V __attribute__((ext_vector_type(LANES)));
typedef __typeof__((V){0} < (V){0}) M; /* as the compiler compares */
typedef uint64_t U __attribute__((ext_vector_type(LANES)));
typedef int32_t I __attribute__((ext_vector_type(LANES)));

#ifndef INLINE
#define INLINE static inline __attribute__((always_inline, unused))
#endif
#define AS(type, x) __builtin_convertvector(x, type)

INLINE bool any(M m) { return __builtin_reduce_or(m) != 0; }

/* x / 3, for which no processor has an instruction: 2^16 leaves 1 when it is divided by 3, and what
 * 3 divides is multiplied by the inverse of 3 modulo 2^64. */
INLINE U third(U x) {
    const U pairs = (x >> 32) + (x & 0xFFFFFFFFu), sum = (pairs >> 16) + (pairs & 0xFFFFu);
    const U rest = sum - 3u * ((sum * 0xAAAAAAABu) >> 33);
    return (x - rest) * 0xAAAAAAAAAAAAAAABu;
}

/* Write n numbers where the mask says so. */
INLINE void blend(M m, void *to, const void *from, size_t n) {
    V *a = to;
    const V *b = from;
    for (size_t i = 0; i < n; i++)
        a[i] = m ? b[i] : a[i];
}

/* Rows of n numbers in an array of them, each lane at its own place. */
INLINE void gather(M m, V *row, const V *array, I place, size_t n) {
    for (int k = 0; k < LANES; k++)
        for (size_t i = 0; m[k] && i < n; i++)
            row[i][k] = array[(size_t)place[k] * n + i][k];
}

INLINE void scatter(M m, const V *row, V *array, I place, size_t n) {
    for (int k = 0; k < LANES; k++)
        for (size_t i = 0; m[k] && i < n; i++)
            array[(size_t)place[k] * n + i][k] = row[i][k];
}

INLINE V gathered(M m, const V *array, I place) {
    V value = 0.0;
    gather(m, &value, array, place, 1);
    return value;
}

#endif
