"""Stage 3: bristle stiffness and damping, from force steps below break-away."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from stickslip import cosim
from stickslip.errors import IdentificationError
from stickslip.identification.stages.estimate import Estimate, covariance
from stickslip.servo.measurement import Array
from stickslip.servo.rig import Log, Rig

LEVELS = (0.6, 0.0, -0.6, 0.3, -0.3, 0.7, 0.1, -0.5, 0.5, -0.7, 0.2, -0.2, 0.65, -0.4, 0.4, 0.0)
"""Force steps in shares of the force that the stage holds."""
HOLD = 0.1  # of each level [s]


@dataclass(frozen=True)
class Presliding:
    """Result of stage 3.

    Attributes
    ----------
    sigma_0 : bristle stiffness [N/m]
    sigma_1 : bristle damping [N s/m]
    log : what was recorded
    x_fit : (n,) position of the fitted model [m]
    """

    sigma_0: Estimate
    sigma_1: Estimate
    log: Log
    x_fit: Array


def measure_presliding(rig: Rig, known: Mapping[str, float], force: float) -> Presliding:
    """Step the force below break-away and fit the stage FMU's position to the encoder's.

    Parameters
    ----------
    known : m, b, F_s, F_c and v_s from the stages before, in SI units
    force : scale of the steps, at which the stage does not yet slide in its weaker direction [N]

    Raises
    ------
    IdentificationError
        When the encoder hardly shows the deflection.
    """
    t = rig.samples(HOLD * len(LEVELS))
    level = np.minimum((t / HOLD + 1e-9).astype(int), len(LEVELS) - 1)
    log = rig.push(np.array(LEVELS)[level] * force)
    deflection = np.ptp(log.x_enc) / 2.0
    if deflection < rig.datasheet.encoder_step:
        raise IdentificationError(
            f"presliding: the stage moved by {np.ptp(log.x_enc):.3g} m, the encoder resolves "
            f"{rig.datasheet.encoder_step:.3g} m; a finer encoder is needed to see sigma_0"
        )
    # Held over the sample before it, F_m is what the current loop has settled to.
    applied = np.append(log.F_m[1:], log.F_m[-1])
    system = cosim.System("presliding")
    system.add("stage", rig.fmus / "stage.fmu", known)
    system.expose("u", "stage.u")
    with system.prepare(step=rig.T_s, stop=t[-1], record=["stage.x"]) as simulation:

        def position(p: Array) -> Array:
            values = {"stage.sigma_0": float(np.exp(p[0])), "stage.sigma_1": float(np.exp(p[1]))}
            return simulation.run(parameters=values, inputs={"u": applied})["stage.x"]

        def residual(p: Array) -> Array:
            gap = position(p) - log.x_enc
            return np.asarray((gap - gap.mean()) / rig.datasheet.encoder_step)

        sigma_0 = 0.5 * np.ptp(log.F_m) / deflection
        damping = [2.0 * ratio * np.sqrt(sigma_0 * known["m"]) for ratio in (0.3, 1.5)]
        fits = [
            least_squares(residual, np.log([sigma_0, sigma_1]), diff_step=[1e-3])
            for sigma_1 in damping
        ]
        fit = min(fits, key=lambda candidate: candidate.cost)
        gap = position(fit.x) - log.x_enc
        x_fit = position(fit.x) - gap.mean()
    values = np.exp(fit.x)
    errors = values * np.sqrt(np.diag(covariance(np.asarray(fit.jac), fit.fun)))
    stiffness, bristle = (Estimate(float(v), float(e)) for v, e in zip(values, errors, strict=True))
    return Presliding(stiffness, bristle, log, x_fit)
