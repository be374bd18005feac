/* Numbers as Python's repr() writes them: the shortest decimal that is read back as the same
 * double, and of those the nearest. Raffaello Giulietti, The Schubfach way to render doubles, 2020.
 */
#include "kernel.h"
#include <math.h>
#include <stdbool.h>
#include <string.h>

__extension__ typedef unsigned __int128 Wide;
typedef struct {
    uint64_t digits;
    int exponent; /* of ten */
} Decimal;

typedef struct {
    const char *begin;
    int64_t length;
} Text; /* of the last other number of a column */

enum { LOWEST = -292 }; /* power of ten in the table */

/* Write lines of a time (n) and numbers (n, width), with commas between; return the length. powers:
 * of ten from LOWEST on, 128 bits each, rounded up. A number takes up to 25 characters; one that is
 * that of the line before is copied, by way of texts (width). */
EXPORT int64_t write_lines(char *text, const double *times, const double *rows, int64_t n,
                           int64_t width, const uint64_t (*powers)[2], Text *texts);

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
    if (q <= 0 && q > -53 && (c & ((1ULL << -q) - 1)) == 0)
        return (Decimal){c >> -q, 0};
    const bool closer = fraction == 0 && exponent > 1; /* the next lower double */
    const uint64_t open = c & 1;                       /* the ends round to another double */
    const int k = (q * 1262611 - (closer ? 524031 : 0)) >> 22;
    const int h = q + log2_of_power_of_10(-k) + 1;
    const uint64_t *power = powers[-k - LOWEST];
    const uint64_t lower = rounded_to_odd(power, (4 * c - 2 + closer) << h) + open;
    const uint64_t value = rounded_to_odd(power, (4 * c) << h);
    const uint64_t upper = rounded_to_odd(power, (4 * c + 2) << h) - open;
    const uint64_t s = value / 4, t = s / 10;
    const bool t_above = 40 * t + 40 <= upper, s_above = 4 * s + 4 <= upper;
    const bool fewer = s >= 10 && (lower <= 40 * t) != t_above;
    const bool nearer = (value > 4 * s + 2) | ((value == 4 * s + 2) & s);
    const bool up = (lower <= 4 * s) != s_above ? s_above : nearer;
    return (Decimal){fewer ? t + t_above : s + up, k + fewer};
}

/* The decimal digits of a number below 1e8, the first one in the lowest byte. */
static uint64_t eight_digits(uint64_t number) {
    const uint64_t fours = number / 10000 | number % 10000 << 32;
    const uint64_t hundreds = (fours * 5243 >> 19) & 0x0000007f0000007f;
    const uint64_t twos = hundreds | (fours - 100 * hundreds) << 16;
    const uint64_t tens = (twos * 103 >> 10) & 0x000f000f000f000f;
    return tens | (twos - 10 * tens) << 8;
}

enum { DIGITS = 17 };

static uint64_t ten_to(int k, const uint64_t (*powers)[2]) {
    return powers[k - LOWEST][0] >> (63 - log2_of_power_of_10(k));
}

static char *put(char *to, const char *from, int n) {
    memcpy(to, from, (size_t)n);
    return to + n;
}

static char *put_number(char *to, double number, const uint64_t (*powers)[2]) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    if (isnan(number))
        return put(to, "nan", 3);
    *to = '-';
    to += bits >> 63;
    if (isinf(number))
        return put(to, "inf", 3);
    if (number == 0.0)
        return put(to, "0.0", 3);
    const Decimal d = shortest(bits & ~(1ULL << 63), powers);
    /* With 17 digits, zeros at the end among them, all are where they are written, but for a point.
     */
    const int about = (64 - __builtin_clzll(d.digits)) * 1233 >> 12;
    const int size = about + (d.digits >= ten_to(about, powers));
    const uint64_t digits = d.digits * ten_to(DIGITS - size, powers);
    const uint64_t upper = digits / 100000000, first = upper / 100000000;
    const uint64_t middle = eight_digits(upper % 100000000);
    const uint64_t last = eight_digits(digits % 100000000);
    const int unused = last ? __builtin_clzll(last) : middle ? 64 + __builtin_clzll(middle) : 128;
    const int n = DIGITS - unused / 8, point = size + d.exponent;
    const Wide zeros = (Wide)0x3030303030303030 << 64 | 0x3030303030303030;
    const Wide rest = ((Wide)last << 64 | middle) | zeros;
    if (point > 16 || point < -3) {
        *to++ = (char)('0' + first);
        *to = '.';
        memcpy(to + 1, &rest, sizeof rest);
        to += n > 1 ? n : 0;
        *to++ = 'e';
        *to++ = point > 0 ? '+' : '-';
        const int e = point > 0 ? point - 1 : 1 - point;
        *to = (char)('0' + e / 100);
        to += e >= 100;
        *to++ = (char)('0' + e / 10 % 10);
        *to++ = (char)('0' + e % 10);
        return to;
    }
    const bool below = point <= 0; /* one */
    memcpy(to, "0.000000", 8);
    to += below ? 2 - point : 0;
    const int shift = below ? 0 : 8 * (point - 1);
    const Wide before = ((Wide)1 << shift) - 1, here = (Wide)'.' << shift;
    const Wide text = below ? rest : (rest & before) | here | (rest & ~before) << 8;
    to[0] = (char)('0' + first);
    memcpy(to + 1, &text, sizeof text);
    to[DIGITS] = (char)(last >> 56 | '0');
    return to + (below ? n : n > point ? n + 1 : point + 2);
}

int64_t write_lines(char *text, const double *times, const double *rows, int64_t n, int64_t width,
                    const uint64_t (*powers)[2], Text *texts) {
    char *to = text;
    for (int64_t i = 0; i < n; i++) {
        to = put_number(to, times[i], powers);
        for (int64_t j = 0; j < width; j++, rows++) {
            *to++ = ',';
            char *begin = to;
            if (i && memcmp(rows, rows - width, sizeof *rows) == 0) {
                to = put(to, texts[j].begin, (int)texts[j].length);
            } else {
                to = put_number(to, *rows, powers);
                texts[j] = (Text){begin, to - begin};
            }
        }
        *to++ = '\n';
    }
    return to - text;
}
