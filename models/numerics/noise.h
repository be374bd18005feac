/* Noise without a generator to carry along: the n-th draw is a hash of seed, channel and n. */
#ifndef NOISE_H
#define NOISE_H

#include <stdint.h>

/* Finaliser of SplitMix64 (Steele, Lea, Flood, OOPSLA 2014). */
static inline uint64_t mixed(uint64_t x) {
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

/* Draw n of a channel: mean 0, variance 1, normal to within its tails (twelve uniforms summed). */
static inline double noise_draw(double seed, int channel, double n) {
    uint64_t key = mixed((uint64_t)seed * 0x9E3779B97F4A7C15u + (uint64_t)channel + 1u);
    key = mixed(key + (uint64_t)n);
    double sum = -6.0;
    for (uint64_t i = 1; i <= 12; i++)
        sum += (double)(mixed(key + i * 0x9E3779B97F4A7C15u) >> 11) * 0x1p-53;
    return sum;
}

#endif
