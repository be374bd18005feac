/* Memory from the system itself, so that a Windows binary needs no C runtime. */
#ifndef HEAP_H
#define HEAP_H

#include <stddef.h>

/* Zeroed; NULL when there is none left. */
void *heap_get(size_t size);
void heap_free(void *memory);

#endif
