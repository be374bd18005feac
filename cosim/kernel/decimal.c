/* Numbers as Python's repr() writes them: the shortest decimal that is read back as the same
 * double, and of those the nearest. Raffaello Giulietti, The Schubfach way to render doubles, 2020.
 */
#include "kernel.h"
#include <math.h>
#include <string.h>

__extension__ typedef unsigned __int128 Wide;
typedef struct {
    uint64_t digits;
    int exponent; /* of ten */
} Decimal;

enum { LOWEST = -292 }; /* power of ten in the table */

/* Write lines of numbers (n, width), with commas between; return the length. powers: of ten from
 * LOWEST on, 128 bits each, rounded up. A number takes up to 25 characters. */
EXPORT int64_t write_lines(char *text, const double *numbers, int64_t n, int64_t width,
                           const uint64_t (*powers)[2]);

static int log2_of_power_of_10(int e) { return (e * 1741647) >> 19; }

/* The upper half of power * c, its last bit set where anything is below it. */
static uint64_t rounded_to_odd(const uint64_t power[2], uint64_t c) {
    const Wide low = (Wide)power[1] * c, high = (Wide)power[0] * c + (uint64_t)(low >> 64);
    return (uint64_t)(high >> 64) | ((uint64_t)high > 1);
}

static Decimal shortest(uint64_t bits, const uint64_t (*powers)[2]) {
    const uint64_t fraction = bits & ((1ULL << 52) - 1);
    const int exponent = (int)(bits >> 52 & 2047);
    const uint64_t c = exponent ? fraction | 1ULL << 52 : fraction;
    const int q = (exponent ? exponent : 1) - 1075;
    if (q <= 0 && q > -53 && (c & ((1ULL << -q) - 1)) == 0) {
        return (Decimal){c >> -q, 0};
    }
    const bool closer = fraction == 0 && exponent > 1; /* the next lower double */
    const uint64_t open = c & 1;                       /* the ends round to another double */
    const int k = (q * 1262611 - (closer ? 524031 : 0)) >> 22;
    const int h = q + log2_of_power_of_10(-k) + 1;
    const uint64_t *power = powers[-k - LOWEST];
    const uint64_t lower = rounded_to_odd(power, (4 * c - 2 + closer) << h) + open;
    const uint64_t value = rounded_to_odd(power, (4 * c) << h);
    const uint64_t upper = rounded_to_odd(power, (4 * c + 2) << h) - open;
    const uint64_t s = value / 4, tens = s / 10;
    if (s >= 10 && (lower <= 40 * tens) != (40 * tens + 40 <= upper)) {
        return (Decimal){tens + (40 * tens + 40 <= upper), k + 1};
    }
    if ((lower <= 4 * s) != (4 * s + 4 <= upper)) {
        return (Decimal){s + (4 * s + 4 <= upper), k};
    }
    return (Decimal){s + (value > 4 * s + 2 || (value == 4 * s + 2 && s & 1)), k};
}

static char *put(char *to, const char *from, int n) {
    memcpy(to, from, (size_t)n);
    return to + n;
}

static char *put_zeros(char *to, int n) {
    memset(to, '0', (size_t)n);
    return to + n;
}

static char *put_number(char *to, double number, const uint64_t (*powers)[2]) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    if (isnan(number)) {
        return put(to, "nan", 3);
    }
    if (bits >> 63) {
        *to++ = '-';
    }
    if (isinf(number)) {
        return put(to, "inf", 3);
    }
    if (number == 0.0) {
        return put(to, "0.0", 3);
    }
    Decimal d = shortest(bits & ~(1ULL << 63), powers);
    for (; d.digits % 10 == 0; d.exponent++) {
        d.digits /= 10;
    }
    char digits[20], *begin = digits + sizeof digits;
    for (; d.digits; d.digits /= 10) {
        *--begin = (char)('0' + d.digits % 10);
    }
    const int n = (int)(digits + sizeof digits - begin), point = n + d.exponent;
    if (point > 16 || point < -3) {
        *to++ = *begin;
        if (n > 1) {
            *to++ = '.';
            to = put(to, begin + 1, n - 1);
        }
        *to++ = 'e';
        *to++ = point > 0 ? '+' : '-';
        const int e = point > 0 ? point - 1 : 1 - point;
        if (e >= 100) {
            *to++ = (char)('0' + e / 100);
        }
        *to++ = (char)('0' + e / 10 % 10);
        *to++ = (char)('0' + e % 10);
        return to;
    }
    if (point <= 0) {
        return put(put_zeros(put(to, "0.", 2), -point), begin, n);
    }
    if (point >= n) {
        return put(put_zeros(put(to, begin, n), point - n), ".0", 2);
    }
    to = put(to, begin, point);
    *to++ = '.';
    return put(to, begin + point, n - point);
}

int64_t write_lines(char *text, const double *numbers, int64_t n, int64_t width,
                    const uint64_t (*powers)[2]) {
    char *to = text;
    for (int64_t i = 0; i < n * width; i++) {
        to = put_number(to, numbers[i], powers);
        *to++ = (i + 1) % width ? ',' : '\n';
    }
    return to - text;
}
