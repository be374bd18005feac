"""The global minimum: several starts of the fit, and a selection among model variants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from stickslip.catalog.space import Values
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.fitting.fit import BLOCKS, FTOL, Criterion, Fit, fit
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE, identifiability
from stickslip.identification.fitting.start import Start
from stickslip.progress import steps
from stickslip.servo.measurement import Array
from stickslip.thresholds import law_choice

STEEPER = 0.5
WIDER = 1.5  # ratio of v_s with the exponent 2 to that with 1, for the same friction
AMBIGUITY = 0.6
"""Standard error, as share of the distance between two fits, where neither is better."""


def best_fit(inverse: InverseModel, start: Start, values: Values) -> Fit:
    """Fit from the result of a search, from a typical Stribeck curve there, and from the line.

    A search ends now and then in a local minimum: of a curve that falls over the whole range
    of speeds, compensated by viscous friction; or, where the drive rests for long, of bristles
    that are too stiff to show.
    """
    known = ("m", "b", "F_0", "F_c", *inverse.space.rise)
    usual = {**values, **{name: start.line[name] for name in known if name in start.line}}
    if "v_s" in usual:
        usual["v_s"] *= STEEPER
    starts = [inverse.space.encode(at) for at in (values, start.line, usual)]
    return fit(inverse, steps(starts))


def without_stribeck(criterion: Criterion, found: Fit) -> Fit:
    """Return a fit without a rise of friction towards rest, if the recording does not require one.

    A compensator would compensate a rise that no measurement shows, and a force
    that does not exist pushes the drive. A rise that spreads over all speeds is a part of b.
    """
    errors, space = found.errors(), found.space
    if not space.bounded or all(
        identifiability(name, found, errors, BLOCKS).identifiability != NOT_IDENTIFIABLE
        for name in space.rise
    ):
        return found
    q = found.q.copy()
    q[[space.index(name) for name in space.bounded]] = 0.0
    flat = fit(criterion.over(space.level()), [q])
    return flat if flat.noise < law_choice.RISE_WORTH * found.noise else found


def variants(criterion: Criterion, found: Fit, ftol: float = FTOL) -> list[Fit]:
    """Return a fit for each of the values to choose from, such as the exponents 1 and 2.

    The preferred one is the first. Where no Stribeck curve shows, ``found`` is the only one.
    """
    space, fits = found.space, [found]
    for name, parameter in space.law.parameters.items():
        is_constant = name in space.constants and parameter.choices
        if not is_constant or (parameter.requires and space.is_level):
            continue
        for choice in parameter.choices:
            change = choice - space.constants[name]
            if not change:
                continue
            q = found.q.copy()
            if parameter.requires and "v_s" in space.names:
                q[space.index("v_s")] += np.log(WIDER) * change
            fits.append(fit(criterion.over(space.fixed(**{name: choice})), [q], ftol))
        order = parameter.choices.index
        fits.sort(key=lambda one: order(one.space.constants[name]))
    return fits


@dataclass(frozen=True)
class Selection:
    """One of several fits of the same recording."""

    fit: Fit  # the selected one
    ambiguity: Array  # (k, k) covariance of its coordinates from not knowing which one is right


def select(fits: Sequence[Fit], sure: float | None = None) -> Selection:
    """Select the first fit, or the best of those that leave less than ``sure`` times its variance.

    Where neither of two fits is sure, the interval of 95 % contains both. With ``sure = 0`` the
    first fit is always selected, and is never sure.
    """
    first, sure = fits[0], law_choice.EXPONENT if sure is None else sure
    better = [one for one in fits[1:] if one.noise < sure * first.noise]
    best = min(better, key=lambda one: one.noise, default=first)
    ambiguity = np.zeros_like(best.covariance)
    for other in fits:
        is_alike = other.noise >= sure * best.noise and best.noise >= sure * other.noise
        if other is not best and is_alike and other.space.names == best.space.names:
            apart = AMBIGUITY * (other.q - best.q)
            ambiguity = ambiguity + np.outer(apart, apart)
    return Selection(best, ambiguity)
