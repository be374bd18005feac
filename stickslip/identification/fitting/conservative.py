"""What a compensator takes where the recording leaves a value open: the value that cannot hurt.

Feedforward that is too weak leaves a part of the friction to the controller, as all of it is left
without a compensator. Feedforward that is too strong, or lasts too long, pushes where there is no
friction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from stickslip.catalog.space import ParameterSpace, Values
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.fitting.identifiability import (
    IDENTIFIABLE,
    NOT_IDENTIFIABLE,
    VALUE,
    Identifiability,
)
from stickslip.models import LawParameter
from stickslip.servo.measurement import smoothed
from stickslip.thresholds import identifiable

CREEP = 0.1  # share of the highest speed up to which friction towards rest shows


def conservative(
    known: Mapping[str, Identifiability], space: ParameterSpace, largest: float
) -> dict[str, Identifiability]:
    """Return the same with the values that the compensator takes.

    A value that is not identifiable is moved to the end of its interval at which the force is the
    weakest; static friction is then the Coulomb friction. Unless it is identifiable, static
    friction is not above the largest one that the recording shows.

    Parameters
    ----------
    largest : friction along the recording [N]
    """
    taken = dict(known)
    for name, one in known.items():
        parameter = space.law.parameters.get(name)
        if parameter and not parameter.at_least and one.identifiability == NOT_IDENTIFIABLE:
            value = _weakest(parameter, one)
            taken[name] = replace(one, value=value, template=_template(name, VALUE, one))
    for name, bound in space.bounded.items():
        one, least = known[name], taken[bound].value
        most = max(identifiable.BEYOND * largest, least)
        if one.identifiability == NOT_IDENTIFIABLE:
            value, what = least, bound
        elif one.identifiability != IDENTIFIABLE and one.value > most:
            value, what = max(largest, least), VALUE
        else:
            value, what = max(one.value, least), ""
        template = _template(name, what, one) if what and value < one.value else one.template
        taken[name] = replace(one, value=value, low=min(one.low, value), template=template)
    return taken


def largest_friction(inverse: InverseModel, values: Values) -> float:
    """Return the largest friction of a recording at standstill and creep [N].

    It is bounded by what was measured and by what the values predict, which has less noise.
    """
    speed = np.abs(inverse.motion.v[inverse.used])
    slow = speed <= CREEP * np.quantile(speed, 0.99)
    predicted = inverse.friction(values)
    modelled = smoothed(predicted, inverse.T_s, inverse.cutoff)[inverse.used]
    measured = modelled + inverse.residual(values)
    largest = (np.max(np.abs(one[slow])) for one in (predicted[inverse.used], measured))
    return float(min(largest))


def bounded_by(values: Values, space: ParameterSpace, largest: float) -> dict[str, float]:
    """Return values with no static friction above the largest one of the recording [N]."""
    reduced = {
        name: min(values[name], max(largest, values[bound]))
        for name, bound in space.bounded.items()
    }
    return {**values, **reduced}


def _weakest(parameter: LawParameter, one: Identifiability) -> float:
    if parameter.weakest == "high":
        return one.high
    is_contact = (parameter.force, parameter.length) == (1, -1)
    return max(one.low, identifiable.SOFTEST * one.value if is_contact else 0.0)


def _template(name: str, what: str, one: Identifiability) -> str:
    if one.identifiability != NOT_IDENTIFIABLE:
        return f"{one.template}; {name} = {what} is taken, the largest friction in the recording"
    taken = f"{name} = {what} is taken, as {name} is {NOT_IDENTIFIABLE}"
    return one.template.replace(NOT_IDENTIFIABLE, taken)
