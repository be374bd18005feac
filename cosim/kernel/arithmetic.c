#include "arithmetic.h"
#include "kernel.h"

/* For calls that the kernel does not make. */
EXPORT void begin_plain_arithmetic(Arithmetic *before);
void begin_plain_arithmetic(Arithmetic *before) { *before = begin_plain(); }
EXPORT void end_plain_arithmetic(const Arithmetic *before);
void end_plain_arithmetic(const Arithmetic *before) { end_plain(before); }
