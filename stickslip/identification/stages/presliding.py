"""Stage 3: stiffness and damping of the contact, from force steps below break-away."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from stickslip import cosim
from stickslip.catalog.estimate import UNKNOWN, Estimate, covariance
from stickslip.catalog.parameters import presliding
from stickslip.models import LawParameter
from stickslip.rigs.contract import Log, Rig
from stickslip.servo.measurement import Array
from stickslip.thresholds import stage

LEVELS = (0.6, 0.0, -0.6, 0.3, -0.3, 0.7, 0.1, -0.5, 0.5, -0.7, 0.2, -0.2, 0.65, -0.4, 0.4, 0.0)
"""Force steps in shares of the force that the stage holds."""
HOLD = 0.1  # of each level [s]
RATIOS = (0.3, 1.5)  # of damping, at which the fit starts
MOST = 700.0  # largest logarithm of a parameter that is tried
FARTHEST = np.log(1e3)  # from the start, of a parameter that counts as found
STIFFER = np.geomspace(1.0, 30.0, 30)  # than force over deflection, where the law has no damping


@dataclass(frozen=True)
class Presliding:
    """Result of stage 3."""

    estimates: dict[str, Estimate]  # the parameters of the law that presliding shows, by name
    stiffness: float  # force over deflection [N/m]
    log: Log  # what was recorded
    x_fit: Array  # (n,) position of the fitted model [m]
    warning: str = ""  # why the estimates are start values, or empty


def measure_presliding(rig: Rig, known: Mapping[str, float], force: float) -> Presliding:
    """Step the force below break-away and fit the stage FMU's position to the encoder's.

    Where the encoder does not show the deflection, or no parameters fit, the estimates are start
    values with a wide standard error, and ``warning`` says so.

    Parameters
    ----------
    known : m, b and parameters of the law from the stages before, in SI units
    force : scale of the steps, at which the stage does not yet slide in its weaker direction [N]
    """
    t = rig.samples(HOLD * len(LEVELS))
    level = np.minimum((t / HOLD + 1e-9).astype(int), len(LEVELS) - 1)
    log = rig.push(np.array(LEVELS)[level] * force)
    step = rig.datasheet.encoder_step
    deflection = np.ptp(log.x_enc) / 2.0
    stiffness = 0.5 * np.ptp(log.F_m) / max(deflection, step)
    # Held over the sample before it, F_m is what the current loop has settled to.
    applied = np.append(log.F_m[1:], log.F_m[-1])
    shown = [rig.law.parameters[name] for name in presliding(rig.law)]
    system = cosim.System("presliding")
    system.add("stage", rig.fmus / "stage.fmu", known)
    system.expose("u", "stage.u")
    with system.prepare(step=rig.T_s, stop=t[-1], record=["stage.x"]) as simulation:

        def position(p: Array) -> Array:
            values = {
                f"stage.{one.name}": float(np.clip(np.exp(min(q, MOST)), one.low, one.high))
                for one, q in zip(shown, p, strict=True)
            }
            return simulation.run(parameters=values, inputs={"u": applied})["stage.x"]

        def residual(p: Array) -> Array:
            gap = position(p) - log.x_enc
            return np.asarray((gap - gap.mean()) / step)

        starts = _starts(shown, stiffness, known["m"])
        p, errors, warning = starts[0], np.full(len(shown), UNKNOWN), ""
        if shown and deflection < step:
            warning = f"the encoder, whose step is {step:.3g} m, shows no deflection before sliding"
        elif shown:
            fit = _least(residual, starts)
            if len(starts) == 1:  # without damping there are many local minima
                stiffer = (_starts(shown, f * stiffness, known["m"])[0] for f in STIFFER)
                nearest = min(stiffer, key=lambda start: float(np.sum(residual(start) ** 2)))
                fit = min(fit, _least(residual, [nearest]), key=lambda candidate: candidate.cost)
            p, errors, warning = _evaluated(fit, starts[0], _left(fit.fun, log, step))
        gap = position(p) - log.x_enc
        x_fit = position(p) - gap.mean()
    values = np.exp(p)
    estimates = {
        one.name: Estimate(float(value), float(value * error))
        for one, value, error in zip(shown, values, errors, strict=True)
    }
    if warning:
        kept = ", ".join(
            f"{name} = {one.value:.3g} +- {one.standard_error:.2g}"
            for name, one in estimates.items()
        )
        warning = f"presliding: {warning}; the compensator begins at {kept}"
    return Presliding(estimates, stiffness, log, x_fit, warning=warning)


def _least(residual: Callable[[Array], Array], starts: Iterable[Array]) -> OptimizeResult:
    fits = [least_squares(residual, start, diff_step=[1e-3]) for start in starts]
    return min(fits, key=lambda candidate: candidate.cost)


def _left(residual: Array, log: Log, step: float) -> float:
    """Return the share of the deflection that a residual in encoder steps is."""
    return float(np.std(residual) * step / np.std(log.x_enc))


def _evaluated(fit: OptimizeResult, start: Array, left: float) -> tuple[Array, Array, str]:
    """Return logarithms of parameters, their standard errors, and what is wrong with them."""
    errors = np.sqrt(np.diag(covariance(np.asarray(fit.jac), fit.fun)))
    near = np.clip(fit.x, start - FARTHEST, start + FARTHEST)
    unseen = (near != fit.x) | (errors == 0.0) | (errors > UNKNOWN)
    errors[unseen] = UNKNOWN
    warning = "not all parameters of the law show" if unseen.any() else ""
    if left > stage.POOR:
        warning = f"the fitted law leaves {100.0 * left:.0f} % of the deflection"
    return near, errors, warning


def _starts(shown: list[LawParameter], stiffness: float, mass: float) -> list[Array]:
    """Return logarithms of parameters for this stiffness [N/m], damped less and more."""
    damping = [2.0 * ratio * np.sqrt(stiffness * mass) for ratio in RATIOS]
    values = [[rate if one.unit == "N.s/m" else stiffness for one in shown] for rate in damping]
    different = {tuple(row): np.log(row) for row in values}
    return list(different.values())
