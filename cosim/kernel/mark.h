/* Which call an FMU is in, written where another process can read it when this one has died.
 * Compiled with MARKED only; else it costs nothing.*/
#ifndef COSIM_MARK_H
#define COSIM_MARK_H

typedef struct {
    const void *first;     /* component of the run */
    const void *component; /* that is being called; NULL: the one that is named elsewhere */
    double t;              /* s, of its step; not a number before the first */
    char call[64];
} Mark;

#ifdef MARKED
#include <string.h>
extern Mark *mark;
/* The name is a literal, so that this is a store or two. */
#define MARK(c, name) (mark->component = (c), (void)memcpy(mark->call, name, sizeof name))
#define MARK_CALL(name) strncpy(mark->call, name, sizeof mark->call - 1)
#define MARK_TIME(time) (mark->t = (time))
#define MARK_FIRST(c) (mark->first = mark->first ? mark->first : (c))
#else
#define MARK(c, name) ((void)0)
#define MARK_CALL(name) ((void)0)
#define MARK_TIME(time) ((void)0)
#define MARK_FIRST(c) ((void)0)
#endif

#endif
