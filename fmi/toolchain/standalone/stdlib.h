/* Stands where there is no C library: what the FMI headers ask of it. */
#include <stddef.h>
