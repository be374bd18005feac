"""Goodness of fit: the relative errors of a model against a recording."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from stickslip.catalog.parameters import Values
from stickslip.identification.criteria.controller_check import ControllerCheck
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import KnownLoop
from stickslip.identification.criteria.motion import Scale, measured_force, position_of
from stickslip.identification.criteria.runs import Diverged, Rows
from stickslip.servo.measurement import Array

LOOP = ("position", "velocity", "closed_loop_force")
ERRORS = ("force", "force_unfiltered", *LOOP)


@dataclass(frozen=True)
class GoodnessOfFit:
    """Relative errors: root mean square of the difference over that of the recorded signal."""

    force: float  # of the inverse model, measured and predicted force low-passed alike
    force_unfiltered: float  # the same, with the measured force as it is
    # of the closed loop run with the recorded commands; NaN when the controller is not known, or
    # the loop runs away with it
    position: float
    velocity: float
    closed_loop_force: float
    t: Array  # (n,) [s]
    measured: Array  # (n,) force, measured [N]
    predicted: Array  # (n,) force predicted by the inverse model [N]
    simulated: Array | None  # (n,) position of the closed loop [m]; None in the same cases
    velocity_recorded: Array  # (n,) of the recorded motion, low-passed [m/s]
    delay: float  # of the force, with which the inverse model is nearest to it [s]
    used: Rows  # samples without the ends that the low-pass spoils

    def errors(self) -> dict[str, float]:
        """Return the relative errors by name."""
        return {name: value for name, value in vars(self).items() if name in ERRORS}

    def scaled(self, scale: Scale) -> "GoodnessOfFit":
        """Return the signals in other units; relative errors stay."""
        simulated = None if self.simulated is None else self.simulated * scale.length
        return replace(
            self,
            measured=self.measured * scale.force,
            predicted=self.predicted * scale.force,
            simulated=simulated,
            velocity_recorded=self.velocity_recorded * scale.length,
        )


def goodness_of_fit(
    inverse: InverseModel,
    values: Values,
    gains: Mapping[str, float] | None,
    check: ControllerCheck | None,
) -> GoodnessOfFit:
    """Return the goodness of fit of values by name."""
    recording = inverse.recording
    delays = (values["delay"], *(np.arange(-3.0, 5.01, 0.25) * recording.T_s))
    delay: float = min(  # of the logged force, which suits the inverse model best [s]
        delays, key=lambda one: float(np.sum(inverse.residual({**values, "delay": one}) ** 2))
    )
    at = {**values, "delay": delay}
    rows = inverse.measured(at), inverse.predicted(at)
    force = relative(*(signal[inverse.used] for signal in rows))
    measured, predicted = map(inverse.at_samples, rows)
    used = inverse.samples_used
    raw = np.interp(recording.t - delay, recording.t, measured_force(recording))
    unfiltered = relative(raw[used], predicted[used])
    errors, simulated = dict.fromkeys(LOOP, math.nan), None
    if gains is not None and check is not None:
        errors, simulated = _closed_loop(inverse, values, gains, check) or (errors, None)
    return GoodnessOfFit(
        force,
        unfiltered,
        **errors,
        t=recording.t,
        measured=measured,
        predicted=predicted,
        simulated=simulated,
        velocity_recorded=inverse.at_samples(inverse.motion.v),
        delay=delay,
        used=used,
    )


def _closed_loop(
    inverse: InverseModel, values: Values, gains: Mapping[str, float], check: ControllerCheck
) -> tuple[dict[str, float], Array] | None:
    """Return the relative errors of ``LOOP`` and the position (n,) [m]."""
    recording = inverse.recording
    with KnownLoop(inverse.fmus, recording, gains) as loop:
        try:
            result = loop.bounded({**values, "delay": max(values["delay"], 0.0)})
        except Diverged:
            return None
    simulated, position = result["candidate.x"], position_of(recording)
    velocity = [np.diff(signal) / recording.T_s for signal in (position, simulated)]
    commanded = np.append(result["controller.u"][1:], 0.0) + values["F_0"]
    n = len(commanded) - check.shift - 1
    logged = measured_force(recording)[check.shift : check.shift + n]
    pairs = (position, simulated), velocity, (logged, commanded[:n])
    return {name: relative(*pair) for name, pair in zip(LOOP, pairs, strict=True)}, simulated


def relative(recorded: Array, modelled: Array) -> float:
    """Return the norm of the difference (n,) over that of the recorded signal."""
    return float(np.linalg.norm(recorded - modelled) / np.linalg.norm(recorded))
