#include "heap.h"

#ifdef _WIN32
#define SYSTEM(type) __declspec(dllimport) type __stdcall
SYSTEM(void *) GetProcessHeap(void);
SYSTEM(void *) HeapAlloc(void *heap, unsigned long flags, size_t size);
SYSTEM(int) HeapFree(void *heap, unsigned long flags, void *memory);

enum { ZEROED = 8 }; /* HEAP_ZERO_MEMORY */

void *heap_get(size_t size) { return HeapAlloc(GetProcessHeap(), ZEROED, size); }

void heap_free(void *memory) {
    if (memory)
        HeapFree(GetProcessHeap(), 0, memory);
}
#else
#include <stdlib.h>

void *heap_get(size_t size) { return calloc(1, size); }

void heap_free(void *memory) { free(memory); }
#endif
