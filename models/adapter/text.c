#include "text.h"

#include <stdint.h>

typedef struct {
    char *next, *end;
} Writer;

static void put(Writer *w, char c) {
    if (w->next < w->end)
        *w->next++ = c;
}

static void put_text(Writer *w, const char *text) {
    while (*text)
        put(w, *text++);
}

static void put_whole(Writer *w, uint64_t value, int least_digits) {
    char digits[20];
    int n = 0;
    for (; value || n < least_digits; value /= 10)
        digits[n++] = (char)('0' + value % 10);
    while (n)
        put(w, digits[--n]);
}

/* `digits` are six, the first of them of place 10^exponent. */
static void put_digits(Writer *w, uint32_t digits, int exponent) {
    int left = 6;
    for (; left > 1 && digits % 10 == 0; left--)
        digits /= 10;
    const bool scientific = exponent < -4 || exponent >= 6;
    const int before = scientific ? 1 : exponent + 1; /* digits before the point */
    if (before <= 0)
        put_text(w, "0.");
    for (int k = before; k < 0; k++)
        put(w, '0');
    uint32_t place = 1;
    for (int k = 1; k < left; k++)
        place *= 10;
    for (int k = 0; k < left || k < before; k++, place /= 10) {
        if (k == before && k > 0)
            put(w, '.');
        put(w, (char)('0' + (place ? digits / place % 10 : 0)));
    }
    if (scientific) {
        put_text(w, exponent < 0 ? "e-" : "e+");
        put_whole(w, (uint64_t)(exponent < 0 ? -exponent : exponent), 2);
    }
}

static void put_real(Writer *w, double value) {
    if (value != value) {
        put_text(w, "nan");
        return;
    }
    if (value < 0.0) {
        put(w, '-');
        value = -value;
    }
    if (value == 0.0 || value - value != 0.0) {
        put_text(w, value == 0.0 ? "0" : "inf");
        return;
    }
    int exponent = 5; /* value = scaled * 10^(exponent - 5), 1e5 <= scaled < 1e6 */
    for (; value >= 1e6; exponent++)
        value /= 10.0;
    for (; value < 1e5; exponent--)
        value *= 10.0;
    uint32_t digits = (uint32_t)(value + 0.5);
    if (digits == 1000000) {
        digits = 100000;
        exponent++;
    }
    put_digits(w, digits, exponent);
}

bool text_equal(const char *a, const char *b) {
    for (; *a && *a == *b; a++)
        b++;
    return *a == *b;
}

void text_write(char *out, size_t size, const char *format, va_list arguments) {
    Writer w = {out, out + size - 1};
    for (; *format; format++) {
        if (*format != '%') {
            put(&w, *format);
            continue;
        }
        const char size_of = *++format;
        if (size_of == 'l' || size_of == 'z')
            format++;
        if (*format == 's') {
            put_text(&w, va_arg(arguments, const char *));
        } else if (*format == 'g') {
            put_real(&w, va_arg(arguments, double));
        } else if (*format == 'd') {
            const int value = va_arg(arguments, int);
            if (value < 0)
                put(&w, '-');
            put_whole(&w, value < 0 ? -(uint64_t)value : (uint64_t)value, 1);
        } else {
            put_whole(&w,
                      size_of == 'z' ? va_arg(arguments, size_t) : va_arg(arguments, unsigned long),
                      1);
        }
    }
    *w.next = 0;
}
