"""The start of the search: what sliding motion shows, and ranges for the rest."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from stickslip.catalog.parameters import ParameterSpace, Values, covariance, scaled_start, unit_of
from stickslip.errors import IdentificationError
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.motion import SI, Scale, measured_force, position_of
from stickslip.identification.sliding.friction_curve import FrictionCurve, Interval, friction_curve
from stickslip.logs import Finding, Recording
from stickslip.logs.recording import Segment
from stickslip.servo.measurement import level
from stickslip.thresholds import curve_shown, identifiable

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
    findings: tuple[Finding, ...] = ()  # that the mass does not show

    def restored(self, scale: Scale) -> "Start":
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

    @property
    def rise(self) -> dict[str, Interval]:
        """Static friction and Stribeck velocity by name, as far as sliding shows them."""
        if self.curve is None or self.space.is_level:
            return {}
        return {name: one for name, one in self.curve.rise.items() if name in self.space.rise}

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
        found |= {
            name: replace(one, value=float(np.clip(values[name], one.low, one.high)))
            for name, one in self.rise.items()
            if np.log(one.high / one.low) <= 2.0 * identifiable.WEAKLY and not self.is_bent(values)
        }
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

    def is_bent(self, values: Values) -> bool:
        """Whether a law's bristles were still bending where the curve gives the rise."""
        most = curve_shown.BENT * self.curve.near if self.curve else 0.0
        return "sigma_0" in values and values["F_c"] > most * values["sigma_0"]

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
            least = self.line[space.bounded[name]] if name in space.bounded else 1.0
            ends = np.array([interval.low, interval.high])
            ends = np.log(ends / least) if space.is_log[k] else ends / space.units[k]
            lower[k], upper[k] = np.maximum(ends, 0.0) if name in space.bounded else ends
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
    whole = _line(model, top)
    fewer = (("b",),) if whole["m"] > 0.0 else (("m",), ("m", "b"))
    tried = [whole, *(_line(model, top, without) for without in fewer if not _is_shown(whole))]
    at = next((one for one in tried if _is_shown(one)), None)

    def said(name: str, value: float) -> str:
        return f"{value / scale.of(name):.3g} {unit_of(name, rotary=recording.rotary)}"

    straight = f"F = m a + b v + F_c sign(v) gives m = {said('m', whole['m'])}"
    pushed = float(model.force[model.used] @ v[model.used]) > 0.0
    if at is None or (at is not whole and not pushed):
        advice = "check signs and units of force and position (<scale force=-1> turns a sign)"
        if pushed:
            advice = "log a faster motion that slides further and accelerates: stickslip plan"
        raise IdentificationError(
            f"{recording.source}: {straight} and F_c = {said('F_c', whole['F_c'])}; expected both "
            f"above 0: {advice}"
        )
    error = whole["error"]
    findings = _massless(whole["m"], error, f"{straight} +- {said('m', 2.0 * error)}")
    m, F_c = whole["m"] + (2.0 * error if findings else 0.0), at["F_c"]
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
        "b": max(at["b"], 0.0),
        "F_0": at["F_0"],
        "delay": at["delay"],
        **space.constants,
    }
    curve = _curve(model, recording, at["delay"])
    found = Start(line, _around(line, space, top, model), curve, findings)
    shown = {name: one.value for name, one in found.sliding.items()}
    return replace(found, line={**line, **shown})


def _curve(model: InverseModel, recording: Recording, delay: float) -> FrictionCurve | None:
    if model.measures_friction:
        return None
    signals = (position_of(recording).tobytes(), measured_force(recording).tobytes())
    factor = None if recording.friction_factor is None else recording.friction_factor.tobytes()
    step, logs = recording.encoder_step, recording.segments
    known = {"T_s": recording.T_s, "step": step, "delay": delay}
    return _curve_of(*signals, logs=logs, factor=factor, **known)


@lru_cache(1)  # every law that is compared asks for that of the same signals
def _curve_of(
    *signals: bytes, logs: tuple[Segment, ...], factor: bytes | None, **known: float
) -> FrictionCurve | None:
    position, force = map(np.frombuffer, signals)
    factors = None if factor is None else np.frombuffer(factor)
    return friction_curve(position, force, logs=logs, factor=factors, **known)


def _massless(m: float, error: float, figure: str) -> tuple[Finding, ...]:
    """Return what to tell of a mass of a straight line, with its standard error, that is negative.

    Where that is more than chance, the drive hardly slides, so that its friction does not show
    either, or the force is at fault.
    """
    if m >= 0.0:
        return ()
    advice = "log quicker ramps of velocity: stickslip plan --show m"
    found = Finding("warning", "the mass does not show", figure, advice, hides=("m",))
    certain = m < -curve_shown.NEGATIVE * error
    hardly = replace(found, spoils="intervals", hides=("m", "F_c", "F_s"))
    return (hardly if certain else found,)


def _is_shown(line: Values) -> bool:
    """Tell whether a straight line is that of a drive."""
    return line["F_c"] > 0.0 and line["m"] >= 0.0


def _line(model: InverseModel, top: float, without: Collection[str] = ()) -> dict[str, float]:
    """Return m, b, F_c, F_0 and the delay of least squares, and the standard error of m."""
    v = model.motion.v
    used = np.zeros(len(v), dtype=bool)
    used[model.used] = True
    if model.measures_friction:  # the mean force against the motion, from the work it does
        work = float(model.force[used] @ v[used])
        F_0 = 0.5 * float(np.sum(np.quantile(model.force[used], [0.1, 0.9])))
        F_c = work / float(np.abs(v[used]).sum())
        return dict.fromkeys(("m", "b", "delay", "error"), 0.0) | {"F_c": F_c, "F_0": F_0}
    used &= np.abs(v) > FAST * top
    names = [name for name in ("m", "b", "F_0", "F_c") if name not in without]
    every = np.column_stack([model.linear, np.sign(v)])[used]
    regressors = every[:, [name not in without for name in ("m", "b", "F_0", "F_c")]]
    lines = []
    for delay in DELAYS * model.recording.T_s:
        force = np.interp(model.t - delay, model.t, model.force)[used]
        found, *_ = np.linalg.lstsq(regressors, force, rcond=None)
        rest = force - regressors @ found
        lines.append((float(rest @ rest), float(delay), found.tolist(), rest))
    _, delay, found, rest = min(lines, key=lambda line: line[:2])
    error = float(np.sqrt(covariance(regressors, rest)[0, 0]))
    values = dict.fromkeys(("m", "b"), 0.0) | dict(zip(names, found, strict=True))
    return values | {"delay": delay, "error": error}


def _around(
    line: dict[str, float], space: ParameterSpace, top: float, model: InverseModel
) -> ParameterSpace:
    """Return the space with weak priors: a factor of e^3 for what the line does not show."""
    F_c, k = line["F_c"], len(space.names)
    at, log = space.index, space.is_log
    units = np.ones(k)
    units[[at("b"), at("F_0"), at("delay")]] = F_c / top, F_c, model.recording.T_s
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
