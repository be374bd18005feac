"""Another log against a learned drive: force, closed loop, and what of the drive has changed.

Nothing is fitted to the log but the time by which its force shows late. Errors are compared with
what noise, the steps of the encoder and the intervals of the parameters make.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import t as student
from threadpoolctl import threadpool_limits

from stickslip.catalog.parameters import Values, friction_law
from stickslip.evaluation.tracking import LearnedDrive
from stickslip.identification.criteria import motion
from stickslip.identification.criteria.controller_check import ControllerCheck, check_controller
from stickslip.identification.criteria.goodness_of_fit import GoodnessOfFit, goodness_of_fit
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.runs import Diverged
from stickslip.identification.estimation.faults import change_of_friction
from stickslip.identification.selection.folds import encoder_error, explained
from stickslip.logs import Recording
from stickslip.servo.measurement import Array, smoothed
from stickslip.thresholds import transfer

SPANS = 10  # Parts of a log, in which errors are told apart, and of which each is left out in turn
SEEDS = (1, 2, 3)  # Of the noise in simulated loops
FRICTION = "friction"  # Name of the change of friction as a whole
STEP = 0.01  # Relative change of a parameter that gives the derivative of a signal by it


@dataclass(frozen=True)
class SignalError:
    """The error of one predicted signal, root mean squares in SI units."""

    error: float  # recorded less predicted
    relative: float  # the same over that of the recorded signal
    noise: float  # what noise and the steps of encoder and force make
    intervals: float  # at most what the standard errors of the parameters make

    @property
    def ratio(self) -> float:
        """How many times larger the error is than what noise and intervals make together."""
        both = float(np.hypot(self.noise, self.intervals))
        return self.error / both if both > 0.0 else np.inf

    def times(self, factor: float) -> "SignalError":
        """Return it in another unit."""
        return SignalError(
            factor * self.error, self.relative, factor * self.noise, factor * self.intervals
        )


@dataclass(frozen=True)
class Change:
    """By how much something differs, with its 95 % interval."""

    value: float
    low: float
    high: float

    def times(self, factor: float) -> "Change":
        """Return it in another unit."""
        return Change(factor * self.value, factor * self.low, factor * self.high)


@dataclass(frozen=True)
class LogPrediction:
    """What a learned drive predicts of a log, in SI units."""

    recording: Recording
    # errors by signal: force, and where the controller is known position, velocity and
    # closed_loop_force
    signals: Mapping[str, SignalError]
    # of m, b and F_0, and of friction as a share, fitted to what the force leaves
    changes: Mapping[str, Change]
    # a row for each part of the log: begin, end, force_bias (mean of recorded less predicted in the
    # direction of motion), force_error, and position_error where the controller is known
    spans: pd.DataFrame
    # by how much friction changes from begin to end of the log, relative, and its standard error
    drift: tuple[float, float]
    goodness: GoodnessOfFit  # signals over time
    check: ControllerCheck | None  # of the controller; None where it is not known


def predict_log(
    fmus: Path,  # folder of the candidate's FMUs
    recording: Recording,
    # of the log's controller FMU by name; None where it is not known
    gains: Mapping[str, float] | None,
    drive: LearnedDrive,
    errors: Mapping[str, float],  # standard errors of the drive's parameters by name
) -> LogPrediction:
    """Return what a learned drive predicts of a log; raise UsageError without motion or force."""
    scale = motion.recording_scale(recording)
    scaled_gains = None if gains is None else scale.values(gains)
    scaled, values = scale.recording(recording), scale.values(drive.values)
    with threadpool_limits(limits=1, user_api="blas"):
        found = _predict(
            fmus, scaled, scaled_gains, drive.law, values=values, errors=scale.values(errors)
        )
    force, length = 1.0 / scale.force, 1.0 / scale.length
    spans = found.spans.copy()
    for name in spans.columns.drop(["begin", "end"]):
        spans[name] *= force if str(name).startswith("force") else length
    return replace(
        found,
        recording=recording,
        signals={
            name: one.times(force if "force" in name else length)
            for name, one in found.signals.items()
        },
        changes={
            name: one if name == FRICTION else one.times(1.0 / scale.of(name))
            for name, one in found.changes.items()
        },
        spans=spans,
        goodness=found.goodness.scaled(motion.Scale(force, length)),
    )


def _predict(
    fmus: Path,
    recording: Recording,
    gains: Mapping[str, float] | None,
    law: str,
    values: Values,
    errors: Values,
) -> LogPrediction:
    check = None
    if gains is not None:
        check = check_controller(fmus, recording, gains)
        if recording.force is None and recording.friction is None:
            recording = replace(recording, force=check.force)
        gains = check.gains
    with InverseModel(fmus, recording, law=friction_law(law)) as inverse:
        goodness = goodness_of_fit(inverse, values, gains, check)
        used, t = inverse.used, inverse.t[inverse.used]
        residual = inverse.residual({**values, "delay": goodness.delay})
        ahead = np.sign(inverse.motion.v)[used]
        encoder = encoder_error(inverse, values, gains)
        noise = explained(inverse, residual, encoder)
        spread = float(_spread(lambda at: inverse.predicted(at)[used], values, errors))
        drift = change_of_friction(inverse, values)
        changes = _changes(inverse, values, residual - encoder)
    signals = {"force": SignalError(_rms(residual), goodness.force, noise, spread)}
    parts = {"force_bias": residual * ahead, "force_error": residual}
    if gains is not None and (simulated := goodness.simulated) is not None:
        try:
            signals |= _loop_errors(inverse, gains, values, errors, goodness=goodness)
        except Diverged:
            goodness = replace(goodness, simulated=None)
        else:
            parts["position_error"] = motion.means(
                motion.position_of(recording) - simulated, inverse.q
            )[used]
    return LogPrediction(
        recording, signals, changes, _spans(t, parts), drift=drift, goodness=goodness, check=check
    )


def _rms(signal: Array) -> float:
    return float(np.sqrt(np.mean(signal**2)))


def _spread(signals: Callable[[Values], Array], values: Values, errors: Values) -> Array:
    """Return what the standard errors of the parameters make of signals (..., n), uncorrelated."""
    at = signals(values)
    total = np.zeros(at.shape[:-1])
    # An open interval would explain anything.
    known = {k: e for k, e in errors.items() if e <= transfer.INTERVAL * abs(values[k])}
    for name, error in known.items():
        step = STEP * abs(values[name])
        change = (signals({**values, name: values[name] + step}) - at) * error / step
        total += np.mean(change**2, axis=-1)
    return np.sqrt(total)


def _changes(inverse: InverseModel, values: Values, residual: Array) -> dict[str, Change]:
    """Return the changes of mass, damping, friction and offset that explain a residual (k,) best.

    The residual is without the error that the encoder makes, which would look like a change. The
    standard error is a jackknife over spans of the log.
    """
    friction = smoothed(inverse.friction(values), inverse.T_s, inverse.cutoff)
    a, v, one = inverse.linear.T
    columns = {"m": a, "b": v, FRICTION: friction, "F_0": one}
    if inverse.measures_friction:
        columns = {FRICTION: friction, "F_0": one}
    rows = np.column_stack(list(columns.values()))[inverse.used]
    span = np.arange(len(residual)) * SPANS // len(residual)

    def fitted(kept: NDArray[np.bool_]) -> Array:
        return np.asarray(np.linalg.lstsq(rows[kept], residual[kept])[0])

    whole = fitted(span >= 0)
    without = np.array([fitted(span != k) for k in range(SPANS)])
    error = np.sqrt((SPANS - 1) * np.var(without, axis=0))
    half = float(student.ppf(0.975, SPANS - 1)) * error
    ends = zip(whole, whole - half, whole + half, strict=True)
    return {name: Change(*map(float, of)) for name, of in zip(columns, ends, strict=True)}


def _loop_errors(
    inverse: InverseModel,
    gains: Mapping[str, float],
    values: Values,
    errors: Values,
    goodness: GoodnessOfFit,
) -> dict[str, SignalError]:
    """Return the errors of the simulated loop; its noise is that of simulated logs."""
    fmus, recording = inverse.fmus, inverse.recording
    position, step, T_s = motion.position_of(recording), recording.encoder_step, recording.T_s
    noise = float(np.sqrt(max(motion.position_noise(position, step) ** 2 - step**2 / 12.0, 0.0)))
    at = {**values, "delay": max(values["delay"], 0.0)}
    with KnownLoop(fmus, recording, gains) as loop:

        def signals(values: Values) -> Array:
            run = loop.bounded(values)
            return np.array(
                [run["candidate.x"], _velocity(run["candidate.x"], T_s), run["controller.u"]]
            )

        smooth = signals(at)
        spread = _spread(signals, at, errors)
    left = []
    with KnownLoop(fmus, recording, gains, encoder=True) as loop:
        for seed in SEEDS:
            run = loop.bounded(at, {"candidate.noise_x": noise, "candidate.seed": seed})
            x = run["candidate.x_enc"]
            left.append(np.array([x, _velocity(x, T_s), run["controller.u"]]) - smooth)
    made = np.sqrt(np.mean(np.square(left), axis=(0, 2)))
    recorded = (position, _velocity(position, T_s), motion.measured_force(recording))
    relative = (goodness.position, goodness.velocity, goodness.closed_loop_force)
    names = ("position", "velocity", "closed_loop_force")
    return {
        name: SignalError(share * _rms(signal), share, float(noise), float(wide))
        for name, signal, share, noise, wide in zip(
            names, recorded, relative, made, spread, strict=True
        )
    }


def _velocity(position: Array, T_s: float) -> Array:
    return np.append(np.diff(position) / T_s, 0.0)


def _spans(t: Array, parts: Mapping[str, Array]) -> pd.DataFrame:
    """Return a row for each part of the log."""
    rows = []
    for span in np.array_split(np.arange(len(t)), SPANS):
        figures = {
            name: float(np.mean(signal[span])) if name.endswith("bias") else _rms(signal[span])
            for name, signal in parts.items()
        }
        rows.append({"begin": t[span[0]], "end": t[span[-1]], **figures})
    return pd.DataFrame(rows)
