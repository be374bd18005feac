"""Stage 1: the inertia, from accelerations far above friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from stickslip.catalog.estimate import Estimate, covariance
from stickslip.errors import IdentificationError
from stickslip.rigs.contract import Rig
from stickslip.servo.measurement import Array, smoothed
from stickslip.thresholds import stage

FREQUENCY = 5.0  # of the force [Hz]
CYCLES = 10
SHARE = 0.3  # of the peak force
CUTOFF = 100.0  # low-pass on all signals alike [Hz]
FAST = 0.5  # of the top speed: below it bristles turn around, and sign(v) is not friction


@dataclass(frozen=True)
class Inertia:
    """Result of stage 1."""

    m: Estimate  # mass [kg]
    # coarse values of viscous [N s/m] and Coulomb friction [N]
    b: Estimate
    F_c: Estimate
    acceleration: Array  # (n,) [m/s^2]
    force: Array  # (n,) motor force without the friction fitted [N]
    speed: float  # mean of theirs [m/s]

    def check(self, friction: float) -> None:
        """Compare the friction that was fitted with that of a constant velocity [N] at ``speed``.

        Raises
        ------
        IdentificationError
            When they differ by as much as the mass takes: then it is not the mass.
        """
        fitted = self.F_c.value + self.b.value * self.speed
        taken = self.m.value * float(np.abs(self.acceleration).mean())
        if abs(fitted - friction) > taken:
            raise IdentificationError(
                f"inertia: the strong sine shows {fitted:.3g} N of friction at {self.speed:.3g} m/s"
                f"; expected {friction:.3g} N as at constant velocity, to less than the "
                f"{taken:.3g} N that {self.m.value:.3g} kg take. The mass does not show: check "
                "peak_force of the data sheet"
            )


def measure_inertia(rig: Rig) -> Inertia:
    """Push with a strong slow sine and fit F = m a + b v + F_c sign(v) + F_0.

    Force, velocity and acceleration go through the same zero-phase low-pass, and only samples well
    away from a reversal count, so neither the filter nor the bristles bias the fit. Raises
    IdentificationError when the stage hardly moves, or the encoder is not that of the data sheet.
    """
    t = rig.samples(CYCLES / FREQUENCY)
    amplitude = SHARE * rig.datasheet.peak_force
    log = rig.push(amplitude * np.cos(2.0 * np.pi * FREQUENCY * t))
    if np.ptp(log.x_enc) < stage.TRAVEL * rig.datasheet.encoder_step:
        raise IdentificationError(
            f"inertia: a force of {amplitude:.3g} N at {FREQUENCY:g} Hz moved the stage by "
            f"{np.ptp(log.x_enc):.3g} m only; expected at least {stage.TRAVEL:g} encoder steps"
        )
    changes = np.abs(np.diff(log.x_enc))
    step, expected = changes[changes > 0.0].min(), rig.datasheet.encoder_step
    if step > stage.ENCODER_STEP * expected:
        raise IdentificationError(
            f"inertia: the position changes by {step:.3g} m at least; expected steps of "
            f"{expected:.3g} m, encoder_step of the data sheet. Give that of the drive"
        )
    v = np.gradient(smoothed(log.x_enc, rig.T_s, CUTOFF), rig.T_s)
    a = np.gradient(v, rig.T_s)
    force = smoothed(log.F_m, rig.T_s, CUTOFF)
    ends = 0.1  # the filter settles [s]
    inner = (t > ends) & (t < t[-1] - ends)
    used = inner & ((v > FAST * v[inner].max()) | (v < FAST * v[inner].min()))
    regressors = np.column_stack([a, v, np.sign(v), np.ones_like(a)])[used]
    values, *_ = np.linalg.lstsq(regressors, force[used], rcond=None)
    errors = np.sqrt(np.diag(covariance(regressors, force[used] - regressors @ values)))
    m, b, F_c = (Estimate(float(values[i]), float(errors[i])) for i in range(3))
    if m.value <= 0.0:
        raise IdentificationError(
            f"inertia: the fit gives {m.value:.3g} kg; a force of {amplitude:.3g} N does not "
            "make the stage slide, friction holds it"
        )
    net = force[used] - regressors[:, 1:] @ values[1:]
    return Inertia(m, b, F_c, a[used], force=net, speed=float(np.abs(v[used]).mean()))
