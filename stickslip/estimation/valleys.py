"""Which valley of the sum of squares a fit belongs into: from where it begins, with which curve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stickslip.estimation.certainty import NOT_VISIBLE, certainty
from stickslip.estimation.fit import BLOCKS, Fit, Judge, fit
from stickslip.estimation.inverse import InverseModel
from stickslip.estimation.start import Start
from stickslip.estimation.unknowns import LEVEL, Values
from stickslip.measurement import Array

CURVE = ("F_s", "F_c", "v_s")
RISE = ("F_s", "v_s")
STEEPER = 0.5
EXPONENTS = {1.0, 2.0}
SURE = 0.99
"""Ratio of mean squares from which on one exponent counts as better than the other."""
WORTH = 1.1
"""By which factor the mean square must fall to make F_s > F_c believed where it is hardly seen."""


def best_fit(inverse: InverseModel, start: Start, values: Values) -> Fit:
    """Fit from where a search ended, from a usual Stribeck curve there, and from the straight line.

    Searches end now and then in a valley of their own: of a curve that falls over the whole range
    of speeds, with friction that rises in place of it; or, where the drive rests for long, of
    bristles too stiff to be seen.
    """
    usual = {**values, **{name: start.line[name] for name in ("m", "b", "F_0", *CURVE)}}
    usual["v_s"] *= STEEPER
    begins = [start.unknowns.coordinates(at) for at in (values, usual, start.line)]
    return min((fit(inverse, start.unknowns, q) for q in begins), key=lambda found: found.noise)


def without_stribeck(inverse: InverseModel, found: Fit) -> Fit:
    """Return a fit with F_s = F_c, if the recording does not ask for more.

    A rise of friction towards rest that nobody saw would be compensated all the same, and a force
    that is not there pushes the drive. One that spreads over all speeds is a part of b.
    """
    errors = found.errors()
    if all(certainty(name, found, errors, BLOCKS).visible != NOT_VISIBLE for name in RISE):
        return found
    level = found.unknowns.upper.copy()
    level[0] = LEVEL
    q = found.q.copy()
    q[0] = 0.0
    flat = fit(inverse, replace(found.unknowns, upper=level), q)
    return flat if flat.noise < WORTH * found.noise else found


def with_exponent(
    judge: Judge, found: Fit, worth: float = 1.0, sure: float = SURE
) -> tuple[Fit, Array]:
    """Return a fit with the exponent of the Stribeck curve that explains more.

    The paper has 1, much of the literature 2; where no curve shows, it is left. With the fit comes
    the covariance (9, 9) of coordinates from not knowing the exponent: where both explain the
    recording alike, they bound an interval of 95 %.

    Parameters
    ----------
    worth : share of the mean square that the other exponent must fall below to be taken
    sure : ratio of mean squares from which on they are not alike; 0 never trusts them
    """
    known = np.zeros_like(found.covariance)
    if found.unknowns.upper[0] <= LEVEL:
        return found, known
    (other,) = EXPONENTS - {found.unknowns.delta}
    rival = fit(judge, replace(found.unknowns, delta=other), found.q)
    best = rival if rival.noise < worth * found.noise else found
    apart = rival.q - found.q
    alike = sure * rival.noise < found.noise and sure * found.noise < rival.noise
    return best, np.outer(apart, apart) / 4.0 if alike else known
