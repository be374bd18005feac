"""The start of the search: what sliding motion shows, and ranges for the rest."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from stickslip.catalog.parameters import ParameterSpace, Values, scaled_start, unit_of
from stickslip.errors import IdentificationError
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.motion import SI, Scale, measured_force, position_of
from stickslip.identification.sliding.friction_curve import FrictionCurve, Interval, friction_curve
from stickslip.logs import Recording
from stickslip.servo.measurement import level
from stickslip.thresholds import curve_shown

FAST = 0.1  # of the top speed: below it sign(v) is not friction
DELAYS = np.arange(-3.0, 10.01, 0.5)  # in samples
PRESLIDING = {False: 2e-4, True: 3e-2}
"""Share of the travel over which bristles bend, on a drive and on a tribometer: a first guess."""
DECADES = 3.0  # largest distance of a law's parameters from their prior means, in decades
RISE = 1.2  # F_s / F_c
STEEPEST = 20.0  # largest F_s / F_c


@dataclass(frozen=True)
class Start:
    """A straight line through the force, and the friction curve where the drive slides."""

    line: dict[str, float]  # values by name, in SI units; those of the law except F_c are guesses
    space: ParameterSpace  # with bounds and priors around them
    curve: FrictionCurve | None = None  # without a law; None where the drive slides too little

    def restored(self, scale: Scale) -> Start:
        """Return line and curve of a scaled recording in SI units; ``space`` stays scaled."""
        curve = self.curve and self.curve.restored(scale)
        return replace(self, line=scale.restored(self.line), curve=curve)

    @property
    def sliding(self) -> dict[str, Interval]:
        """Mass, viscous friction and constant force by name, as far as sliding shows them."""
        if self.curve is None:
            return {}
        mass, viscous = self.curve.mass, self.curve.viscous
        if mass.low <= 0.0 or viscous.high <= 0.0:
            return {}
        viscous = replace(viscous, value=max(viscous.value, 0.0), low=max(viscous.low, 0.0))
        return {"m": mass, "b": viscous, "F_0": self.curve.offset}

    def beside(self, values: Values) -> dict[str, Interval]:
        """Return what sliding shows, with a law's viscous friction and constant force within it.

        The law's Coulomb friction belongs to them. Where it contradicts the friction curve, the
        straight line through the curve gives Coulomb and viscous friction: a speed counts the less
        the wider the curve's interval there is and the more friction of the law rises towards rest,
        and the errors at all speeds may be alike.
        """
        found = self.sliding
        if self.curve is None or not found:
            return found
        if self.disagreement(values) <= curve_shown.CONTRADICTED:
            own = {name: found[name] for name in ("b", "F_0")}
            return found | {
                name: replace(one, value=float(np.clip(values[name], one.low, one.high)))
                for name, one in own.items()
            }
        curve, viscous = self.curve, found["b"]
        rise = level(values, curve.speed) - values["F_c"]
        half = np.hypot(0.5 * (curve.high - curve.low), rise)
        line = np.column_stack([np.ones_like(half), curve.speed])
        weights = np.linalg.pinv(line / half[:, np.newaxis]) / half
        slope = float(np.clip(weights[1] @ (curve.value - rise), viscous.low, viscous.high))
        beyond = (curve.value - rise - slope * curve.speed) / half**2
        F_c, error = float(np.sum(beyond) / np.sum(half**-2.0)), float(np.abs(weights[0]) @ half)
        if F_c <= error:
            return found
        coulomb = Interval(F_c, 0.5 * error, F_c - error, F_c + error)
        return {**found, "b": replace(viscous, value=slope), "F_c": coulomb}

    def disagreement(self, values: Values) -> float:
        """Return how far a law's values are from what sliding motion shows, in half-widths.

        That is the larger of the distance of the mass, and the root mean square distance of
        friction at the speeds of the curve; each is counted in half of its 95 % interval.
        """
        if self.curve is None or not self.sliding:
            return 0.0
        curve, mass = self.curve, self.curve.mass
        friction = level(values, curve.speed) + values["b"] * curve.speed
        apart = 2.0 * (friction - curve.value) / (curve.high - curve.low)
        mass_apart = 2.0 * (values["m"] - mass.value) / (mass.high - mass.low)
        return max(abs(mass_apart), float(np.sqrt(np.mean(apart**2))))

    def narrow(self, space: ParameterSpace, shown: Mapping[str, Interval]) -> ParameterSpace:
        """Return a space with what sliding shows within its intervals, for the fit of a law.

        Where a law does not explain the motion before the drive slides, the inverse model would
        compensate that by a wrong mass and wrong friction at constant speeds.
        """
        lower, upper = space.lower.copy(), space.upper.copy()
        for name, interval in shown.items():
            k = space.index(name)
            ends = np.array([interval.low, interval.high])
            ends = np.log(ends) if space.is_log[k] else ends / space.units[k]
            lower[k], upper[k] = ends
        return replace(space, lower=lower, upper=upper)


def begin(model: InverseModel, recording: Recording, scale: Scale = SI) -> Start:
    """Fit F(t - delay) = m a + b v + F_c sign(v) + F_0 where the drive slides.

    Raises IdentificationError when the drive hardly moves, or the force does not act in the
    direction of the motion.
    """
    v = model.motion.v
    top = float(np.quantile(np.abs(v[model.used]), 0.999))
    if top <= 0.0:
        raise IdentificationError(f"{recording.source}: the drive does not move")
    m, b, F_c, F_0, delay = _line(model, top)
    if F_c <= 0.0 or (m <= 0.0 and not model.measures_friction):
        advice = "check signs and units of force and position (<scale force=-1> turns a sign)"
        if float(model.force[model.used] @ v[model.used]) > 0.0:
            advice = "log a faster motion that slides further and accelerates: stickslip plan"
        given = {
            name: f"{value / scale.of(name):.3g} {unit_of(name, rotary=recording.rotary)}"
            for name, value in {"m": m, "F_c": F_c}.items()
        }
        raise IdentificationError(
            f"{recording.source}: F = m a + b v + F_c sign(v) gives m = {given['m']} and F_c = "
            f"{given['F_c']}; expected both above 0: {advice}"
        )
    travel = float(np.ptp(np.cumsum(v) * model.T_s))
    share = PRESLIDING[model.measures_friction]
    deflection = float(np.clip(share * travel, 3.0 * recording.encoder_step, 0.05 * travel))
    mass = m if m > 0.0 else 1e-6 * F_c / float(np.std(model.motion.a))
    sigma_0 = F_c / deflection
    space = ParameterSpace.of(model.space.law)
    guesses = {
        "F_s": RISE * F_c,
        "F_c": F_c,
        "v_s": 0.03 * top,
        "sigma_0": sigma_0,
        "sigma_1": 2.0 * float(np.sqrt(sigma_0 * mass)) if m > 0.0 else 1e-3 * sigma_0,
    }
    line = {
        **{
            one.name: guesses.get(one.name, scaled_start(one, F_c, deflection))
            for one in space.parameters
        },
        "m": mass,
        "b": max(b, 0.0),
        "F_0": F_0,
        "delay": delay,
        **space.constants,
    }
    found = Start(line, _around(line, space, top, model), _curve(model, recording, delay))
    shown = {name: one.value for name, one in found.sliding.items()}
    return replace(found, line={**line, **shown})


def _curve(model: InverseModel, recording: Recording, delay: float) -> FrictionCurve | None:
    if model.measures_friction:
        return None
    position, force = position_of(recording).tobytes(), measured_force(recording).tobytes()
    return _curve_of(position, force, model.T_s, recording.encoder_step, delay=delay)


@lru_cache(1)  # every law that is compared asks for that of the same signals
def _curve_of(
    position: bytes, force: bytes, T_s: float, step: float, delay: float
) -> FrictionCurve | None:
    return friction_curve(np.frombuffer(position), np.frombuffer(force), T_s, step, delay=delay)


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


def _around(
    line: dict[str, float], space: ParameterSpace, top: float, model: InverseModel
) -> ParameterSpace:
    """Return the space with weak priors: a factor of e^3 for what the line does not show."""
    F_c, k = line["F_c"], len(space.names)
    at, log = space.index, space.is_log
    units = np.ones(k)
    units[[at("b"), at("F_0"), at("delay")]] = F_c / top, F_c, model.T_s
    mean = replace(space, units=units).encode(line)
    deviation = np.full(k, np.inf)
    wide = DECADES * np.log(10.0)
    lower, upper = mean - wide, mean + wide
    for index, one in enumerate(space.parameters):
        if one.name not in space.law.parameters or one.name == "F_c":
            continue
        if one.at_least:
            mean[index], deviation[index] = np.log(RISE), 0.5
            lower[index], upper[index] = 0.0, np.log(STEEPEST)
        elif log[index]:
            deviation[index] = 3.0
        else:
            lower[index], upper[index] = one.low, one.high
    lower[at("b")], upper[at("b")] = 0.0, 100.0
    lower[at("F_0")], upper[at("F_0")] = mean[at("F_0")] - 10.0, mean[at("F_0")] + 10.0
    lower[at("delay")], upper[at("delay")] = -5.0, 20.0
    if model.measures_friction:  # only friction and its offset show
        deviation[[at("m"), at("b"), at("delay")]] = 1e-6
    return replace(
        space, units=units, prior_mean=mean, prior_deviation=deviation, lower=lower, upper=upper
    )
