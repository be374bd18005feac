/* Messages without a C library: the same text on every platform. */
#ifndef TEXT_H
#define TEXT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

bool text_equal(const char *a, const char *b);

/* Write at most size - 1 characters and a 0. Knows of printf's conversions %s, %d, %lu, %zu and
 * %g; the sixth digit of the last may be one off. */
void text_write(char *out, size_t size, const char *format, va_list arguments);

#endif
