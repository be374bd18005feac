/* A mass on an elasto-plastic contact. */
#include "plants/rodas3.h"

#include "laws/elasto_plastic/elasto_plastic.h"

static Bristle bristle(double v, double z, double scale, const Law *p, BristleSlopes *slopes) {
    const double dz = elasto_plastic_dz(v, side_of(v), z, scale, p, &slopes->zv, &slopes->zz);
    slopes->Fv = p->sigma_1 * slopes->zv;
    slopes->Fz = p->sigma_1 * slopes->zz;
    return (Bristle){dz, p->sigma_1 * dz};
}
