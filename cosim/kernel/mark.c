#include "mark.h"
#include "kernel.h"

#ifdef MARKED
static Mark nowhere;
Mark *mark = &nowhere;
EXPORT void mark_in(Mark *place);
void mark_in(Mark *place) { mark = place; }
#endif
