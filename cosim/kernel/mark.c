#include "mark.h"
#include "kernel.h"
#include <fenv.h>

#ifdef MARKED
static Mark nowhere;
Mark *mark = &nowhere;
EXPORT void mark_in(Mark *place);
void mark_in(Mark *place) { mark = place; }
#endif

/* Undo what an FMU did to rounding and to numbers near zero. */
EXPORT void plain_arithmetic(void);
void plain_arithmetic(void) { fesetenv(FE_DFL_ENV); }
