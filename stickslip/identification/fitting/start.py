"""Where the search begins: a straight line through the force, and ranges for the rest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.errors import IdentificationError
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.unknowns import NAMES, Unknowns
from stickslip.logs import Recording

FAST = 0.1  # of the top speed: below it sign(v) is not friction
DELAYS = np.arange(-3.0, 10.01, 0.5)  # in samples
PRESLIDING = {False: 2e-4, True: 3e-2}
"""Share of the way over which bristles bend, on a drive and on a tribometer: a first guess."""
DECADES = 3.0
"""How far LuGre's parameters may lie from where they are expected."""


@dataclass(frozen=True)
class Start:
    """What a straight line through the force says.

    Attributes
    ----------
    line : values by name, in SI units; those of LuGre but F_c are guesses
    unknowns : with bounds and expectations around them
    """

    line: dict[str, float]
    unknowns: Unknowns


def begin(model: InverseModel, recording: Recording) -> Start:
    """Fit F(t - delay) = m a + b v + F_c sign(v) + F_0 where the drive slides.

    Raises
    ------
    IdentificationError
        When the drive hardly moves, or the force does not push the way it goes.
    """
    v = model.motion.v
    top = float(np.quantile(np.abs(v[model.used]), 0.999))
    if top <= 0.0:
        raise IdentificationError(f"{recording.source}: the drive does not move")
    m, b, F_c, F_0, delay = _line(model, top)
    if F_c <= 0.0 or (m <= 0.0 and not model.measures_friction):
        raise IdentificationError(
            f"{recording.source}: F = m a + b v + F_c sign(v) gives m = {m:.3g} kg and F_c = "
            f"{F_c:.3g} N; expected both above 0: check signs and units of force and position "
            "(--scale force=-1 turns a sign)"
        )
    way = float(np.ptp(np.cumsum(v) * model.T_s))
    share = PRESLIDING[model.measures_friction]
    deflection = np.clip(share * way, 3.0 * recording.encoder_step, 0.05 * way)
    sigma_0 = F_c / deflection
    mass = m if m > 0.0 else 1e-6 * F_c / np.std(model.motion.a)
    values = {
        "F_s": 1.2 * F_c,
        "F_c": F_c,
        "v_s": 0.03 * top,
        "sigma_0": sigma_0,
        "sigma_1": 2.0 * np.sqrt(sigma_0 * mass) if m > 0.0 else 1e-3 * sigma_0,
        "m": mass,
        "b": max(b, 0.0),
        "F_0": F_0,
        "delay": delay,
        "delta": 1.0,
    }
    return Start(values, _unknowns(values, top, model))


def _line(model: InverseModel, top: float) -> tuple[float, float, float, float, float]:
    """Return m, b, F_c, F_0 and the delay of least squares."""
    v = model.motion.v
    used = np.zeros(len(v), dtype=bool)
    used[model.used] = True
    if model.measures_friction:  # the mean force against the motion, from the work it does
        work = float(model.force[used] @ v[used])
        F_0 = 0.5 * float(np.sum(np.quantile(model.force[used], [0.1, 0.9])))
        return 0.0, 0.0, work / float(np.abs(v[used]).sum()), F_0, 0.0
    used &= np.abs(v) > FAST * top
    regressors = np.column_stack([model.linear, np.sign(v)])[used]
    lines = []
    for delay in DELAYS * model.T_s:
        force = np.interp(model.t - delay, model.t, model.force)[used]
        found, *_ = np.linalg.lstsq(regressors, force, rcond=None)
        rest = force - regressors @ found
        lines.append((float(rest @ rest), float(delay), found.tolist()))
    _, delay, (m, b, F_0, F_c) = min(lines)
    return m, b, F_c, F_0, delay


def _unknowns(values: dict[str, float], top: float, model: InverseModel) -> Unknowns:
    """Return coordinates whose expectation is weak: a factor of e^3 for what is not seen."""
    F_c = values["F_c"]
    wide = DECADES * np.log(10.0)
    expected = np.zeros(len(NAMES))
    expected[:6] = np.log([1.2, *(values[name] for name in NAMES[1:6])])
    expected[6:] = values["b"] * top / F_c, values["F_0"] / F_c, values["delay"] / model.T_s
    doubt = np.full(len(NAMES), np.inf)
    doubt[[0, 2, 3, 4]] = 0.5, 3.0, 3.0, 3.0
    lower, upper = expected - wide, expected + wide
    lower[0], upper[0] = 0.0, np.log(20.0)
    lower[6], upper[6] = 0.0, 100.0
    lower[7], upper[7] = expected[7] - 10.0, expected[7] + 10.0
    lower[8], upper[8] = -5.0, 20.0
    if model.measures_friction:  # nothing is pushed: only friction and its offset are seen
        doubt[[5, 6, 8]] = 1e-6
    return Unknowns(F_c / top, F_c, model.T_s, expected, doubt, lower, upper)
