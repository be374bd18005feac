/* A mass on a LuGre contact. */
#include "plants/rodas3.h"

#include "laws/lugre/lugre.h"

static Bristle bristle(double v, double z, double scale, const Law *law, BristleSlopes *slopes) {
    const LuGre contact = LUGRE_OF(law);
    const LuGre *p = &contact;
    double slope;
    const double g = scale * lugre_g(v, p, &slope);
    const double per_reach = p->sigma_0 / g; /* [1/m] */
    const double forgetting = per_reach * absolute(v);
    const double dz = v - forgetting * z;
    double fading;
    const double sigma_1 = lugre_damping(v, p, &fading);
    const double sign = v < 0.0 ? -1.0 : 1.0;
    slopes->zv = 1.0 - per_reach * z * sign * (1.0 - scale * slope / g);
    slopes->zz = -forgetting;
    slopes->Fv = sigma_1 * slopes->zv + fading * dz;
    slopes->Fz = sigma_1 * slopes->zz;
    return (Bristle){dz, sigma_1 * dz};
}
