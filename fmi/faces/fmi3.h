/* What the files of FMI 3.0 share. */
#ifndef FMI3_H
#define FMI3_H

#include <fmi3Functions.h>

#include "face.h"

/* Leave the calling function unless the instance exists and is in one of these phases. */
#define REQUIRE(phases)                                                                            \
    do {                                                                                           \
        if (!instance || instance_require(instance, phases, __func__) != OK)                       \
            return fmi3Error;                                                                      \
    } while (0)

/* Leave it unless the tool gave what must not be NULL. */
#define NEED(given)                                                                                \
    do {                                                                                           \
        if (!(given))                                                                              \
            return (fmi3Status)instance_lacks(instance, __func__);                                 \
    } while (0)

/* Leave it unless as many values came as there are scalar variables. */
#define REQUIRE_COUNT(references, values)                                                          \
    do {                                                                                           \
        if ((values) != (references))                                                              \
            return (fmi3Status)instance_mismatch(instance, references, values, __func__);          \
    } while (0)

#endif
