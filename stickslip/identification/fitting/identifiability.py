"""How well a parameter is known: interval, profile likelihood, and a sentence.

The profile asks how much worse the recording is explained when one parameter is held elsewhere and
all others give way. In the units of the fit its parabola is (distance / standard error)^2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
from scipy.stats import t as student

from stickslip.catalog.parameters import LUGRE
from stickslip.identification.criteria.unknowns import (
    LEVEL,
    LOGS,
    NAMES,
    Values,
)
from stickslip.identification.fitting.fit import Fit, inverse_information
from stickslip.servo.measurement import Array

WELL, WEAKLY = 0.05, 0.3
"""Relative half-widths of a 95 % interval up to which a parameter is well, and weakly, known."""
WELL_KNOWN, WEAKLY_KNOWN, NOT_VISIBLE = "well known", "weakly known", "not visible"
MUTE = 0.5
"""Share of what was expected beforehand that may be left of the doubt, if a recording speaks."""
POINTS = (-3.0, -2.0, -1.0, 1.0, 2.0, 3.0)  # of the profile, in standard errors
PASSES = 3
LOOSE = 0.5
"""Standard error of a coordinate beyond which it stays where it is while others are profiled."""
AT_BOUND = 1e-6
"""A coordinate so near to a bound stays there, too."""

REMEDY = {
    "F_s": "slow reversals",
    "v_s": "slow reversals",
    "sigma_0": "presliding moves",
    "sigma_1": "quick presliding moves",
    "F_c": "constant speeds in both directions",
    "b": "constant speeds over the whole range",
    "m": "quick ramps of velocity",
}
"""Which experiment shows a parameter."""


_Point = tuple[str, float]  # a parameter, and by how many standard errors it is moved
_Row = tuple[str, float, float]


@dataclass(frozen=True)
class Certainty:
    """What is known of one parameter, in SI units.

    Attributes
    ----------
    value, standard_error : of the fit
    low, high : 95 % interval
    visible : ``well known``, ``weakly known`` or ``not visible``
    sentence : the same for people, with the experiment that would help
    """

    value: float
    standard_error: float
    low: float
    high: float
    visible: str
    sentence: str


def certainty(name: str, fitted: Fit, errors: Values, degrees: int) -> Certainty:
    """Judge one parameter.

    Parameters
    ----------
    errors : standard errors by name [SI]
    degrees : of freedom behind them
    """
    value, error = fitted.parameters[name], errors[name]
    factor = float(student.ppf(0.975, degrees))
    if NAMES.index(name) < LOGS and value > 0.0:
        ratio = float(np.exp(min(factor * error / value, 50.0)))
        low, high = value / ratio, value * ratio
    else:
        low, high = value - factor * error, value + factor * error
    relative = factor * error / abs(value) if value else np.inf
    if _mute(name, fitted) or relative > WEAKLY:
        visible = NOT_VISIBLE
        said = f"not visible in this experiment; {_remedy(name)}"
    elif relative > WELL:
        visible = WEAKLY_KNOWN
        said = f"{WEAKLY_KNOWN}, +-{100 * relative:.2g} %; {_remedy(name)}"
    else:
        visible = WELL_KNOWN
        said = f"{WELL_KNOWN}, +-{100 * relative:.2g} %"
    return Certainty(value, error, low, high, visible, said)


def harmless(known: dict[str, Certainty]) -> dict[str, Certainty]:
    """Return the same with F_s = F_c where F_s is not visible: too little force does no harm."""
    F_s, F_c = known["F_s"], known["F_c"]
    if F_s.visible != NOT_VISIBLE or F_s.value <= F_c.value:
        return known
    sentence = F_s.sentence.replace(NOT_VISIBLE, f"F_s = F_c is taken, as F_s is {NOT_VISIBLE}")
    taken = replace(F_s, value=F_c.value, low=min(F_s.low, F_c.low), sentence=sentence)
    return {**known, "F_s": taken}


def unreliable(known: Certainty) -> Certainty:
    """Return the certainty of a value whose recording is at fault: weakly known at best."""
    if known.visible != WELL_KNOWN:
        return known
    sentence = known.sentence.replace(WELL_KNOWN, f"{WEAKLY_KNOWN} at best") + ", see the warnings"
    return replace(known, visible=WEAKLY_KNOWN, sentence=sentence)


def _remedy(name: str) -> str:
    return f"{REMEDY[name]} show it: stickslip plan --show {name}"


def _mute(name: str, fitted: Fit) -> bool:
    """Tell whether what was expected beforehand decides more than the recording."""
    index = NAMES.index(name)
    if name in ("F_s", "v_s") and fitted.unknowns.upper[0] <= LEVEL:
        return True
    doubt = fitted.unknowns.doubt[index]
    if not np.isfinite(doubt):
        return False
    room = fitted.unknowns.upper[index] - fitted.q[index]
    if name != "F_s":  # F_s = F_c is a finding, its upper bound is none
        room = min(room, fitted.q[index] - fitted.unknowns.lower[index])
    return bool(room < AT_BOUND) or float(np.sqrt(fitted.covariance[index, index])) > MUTE * doubt


def profiles(
    fitted: Fit,
    residual: Callable[[Values], Array],
    errors: Values,
    each: Callable[[Callable[[_Point], _Row | None], Iterable[_Point]], list[_Row | None]],
) -> pd.DataFrame:
    """Return the profile likelihoods of LuGre's five.

    Each point holds one parameter and lets the others follow by three Gauss steps with the Jacobian
    of the fit; where that is not enough the curve lies above the true profile. Where a bound keeps
    the parameter from a value there is no point.

    Parameters
    ----------
    residual : (k,) of values by name, as the fit saw it
    errors : standard errors by name [SI]
    each : applies a function to every point, perhaps side by side

    Returns
    -------
    DataFrame
        parameter, value [SI], deviance (twice the loss of log likelihood, 3.84 at 95 %)
    """
    u = fitted.unknowns
    inverse = inverse_information(fitted.jacobian, fitted.noise, u)
    loose = np.sqrt(np.diag(inverse)) > LOOSE
    loose |= np.minimum(fitted.q - u.lower, u.upper - fitted.q) < AT_BOUND
    jacobian = np.where(loose, 0.0, fitted.jacobian)
    frozen = inverse_information(jacobian, fitted.noise, u)
    frozen[loose], frozen[:, loose] = 0.0, 0.0
    weight = np.where(np.isfinite(u.doubt), 1.0 / u.doubt**2, 0.0)

    def loss(rest: Array, q: Array) -> float:
        return float(rest @ rest) / fitted.noise + float(np.sum(u.surprise(q) ** 2))

    least = loss(residual(fitted.parameters), fitted.q)

    def row(point: _Point) -> _Row | None:
        name, distance = point
        value = fitted.parameters[name]
        direction = np.zeros(len(NAMES))
        direction[NAMES.index(name)] = 1.0
        direction[1] = 1.0 if name in ("F_s", "F_c") else 0.0
        index = NAMES.index(name)
        held = bool(loose[index])  # itself alone, as the others do not depend on it
        plain = float(np.sqrt(direction @ (inverse if held else frozen) @ direction))
        relative = max(errors[name] / value, 1e-12)
        wanted = float(direction @ fitted.q) + distance * relative
        q = fitted.q.copy()
        if held:
            q[index] = np.clip(q[index] + distance * relative, u.lower[index], u.upper[index])
        rest, losses = residual(u.values(q)), []
        for _ in range(PASSES):
            gradient = fitted.jacobian.T @ rest / fitted.noise + weight * (q - u.expected)
            step = -frozen @ gradient
            if not held:
                missing = wanted - direction @ (q + step)
                step += frozen @ direction * missing / plain**2
            q = np.clip(q + step, u.lower, u.upper)
            rest = residual(u.values(q))
            losses.append(loss(rest, q))
        if abs(float(direction @ q) - wanted) > AT_BOUND + 1e-3 * abs(distance) * relative:
            return None
        # In the units of the standard error, which knows of correlation.
        scale = (plain / relative) ** 2
        return (
            name,
            value * float(np.exp(distance * relative)),
            max((min(losses) - least) * scale, 0.0),
        )

    middle = [(name, fitted.parameters[name], 0.0) for name in LUGRE]
    beside = each(row, [(name, distance) for name in LUGRE for distance in POINTS])
    rows = middle + [point for point in beside if point is not None]
    table = pd.DataFrame(rows, columns=["parameter", "value", "deviance"])
    return table.sort_values(["parameter", "value"], ignore_index=True)
