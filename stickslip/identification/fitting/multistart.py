"""Which valley of the sum of squares a fit belongs into: from where it begins, with which curve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.unknowns import (
    LEVEL,
    NAMES,
    Values,
)
from stickslip.identification.fitting.fit import (
    BLOCKS,
    Fit,
    Judge,
    fit,
)
from stickslip.identification.fitting.identifiability import NOT_VISIBLE, certainty
from stickslip.identification.fitting.start import Start
from stickslip.servo.measurement import Array

CURVE = ("F_s", "F_c", "v_s")
RISE = ("F_s", "v_s")
V_S = NAMES.index("v_s")
STEEPER = 0.5
WIDER = 1.5
"""Ratio of v_s with the exponent 2 to that with 1, for the same friction."""
SURE = 0.99
"""Ratio of mean squares from which on one exponent counts as better than the other."""
AMBIGUITY = 0.6
"""Standard error, as share of the distance of both fits, where neither is better."""
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


def with_exponent(judge: Judge, found: Fit, sure: float = SURE) -> tuple[Fit, Array]:
    """Return a fit with the exponent of the Stribeck curve that explains the recording.

    It is 1, as in the paper, or 2, as in much of the literature, where 2 leaves less than ``sure``
    times the mean square; where no curve shows, it is left. With the fit comes the covariance
    (9, 9) of coordinates from not knowing it: where neither is sure, both lie in an interval of
    95 %. 0 trusts no mean square.
    """
    known = np.zeros_like(found.covariance)
    if found.unknowns.upper[0] <= LEVEL:
        return found, known
    q, other = found.q.copy(), 3.0 - found.unknowns.delta
    q[V_S] += np.log(WIDER) * (other - found.unknowns.delta)
    rival = fit(judge, replace(found.unknowns, delta=other), q)
    one, two = sorted((found, rival), key=lambda either: either.unknowns.delta)
    apart = AMBIGUITY * (two.q - one.q)
    alike = two.noise >= sure * one.noise and one.noise >= sure * two.noise
    best = two if two.noise < sure * one.noise else one
    return best, np.outer(apart, apart) if alike else known
