"""Stage 1, which measures the mass, and stage 3, which measures presliding."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import OptimizeResult, least_squares

from stickslip import cosim
from stickslip.catalog.parameters import UNKNOWN, Estimate, covariance, presliding
from stickslip.errors import IdentificationError
from stickslip.models import LawParameter
from stickslip.rigs.contract import Log, Rig
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
    b: Estimate  # coarse viscous friction [N s/m]
    F_c: Estimate  # coarse Coulomb friction [N]
    acceleration: Array  # (n,) [m/s^2]
    force: Array  # (n,) motor force without the friction fitted [N]
    speed: float  # mean of theirs [m/s]

    def check(self, friction: float) -> None:
        """Compare the fitted friction with that of a constant velocity [N], or raise."""
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
    values with a wide standard error, and ``warning`` says so. The values known are m, b and
    parameters of the law from the stages before, in SI units. The force [N] scales the steps; at it
    the stage does not yet slide in its weaker direction.
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
            left = float(np.std(fit.fun) * step / np.std(log.x_enc))  # share of the deflection
            p, errors, warning = _evaluated(fit, starts[0], left)
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
