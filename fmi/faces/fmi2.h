/* What the files of FMI 2.0 share. */
#ifndef FMI2_H
#define FMI2_H

#include <fmi2Functions.h>

#include "face.h"

/* Leave the calling function unless the instance exists and is in one of these phases. */
#define REQUIRE(phases)                                                                            \
    do {                                                                                           \
        if (!c || instance_require(c, phases, __func__) != OK)                                     \
            return fmi2Error;                                                                      \
    } while (0)

/* Leave it unless the tool gave what must not be NULL. */
#define NEED(given)                                                                                \
    do {                                                                                           \
        if (!(given))                                                                              \
            return (fmi2Status)instance_lacks(c, __func__);                                        \
    } while (0)

#endif
