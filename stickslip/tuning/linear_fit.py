"""Least squares on recorded runs of the drive: which parameters would have left the smallest gap.

The loop is linear in the compensator's force, so from recorded runs follows how the gap v - v_r
would change with the parameters; the fit needs no further runs. Runs are repeated, because the
encoder's steps pass through the loop differently each time, and the command is run mirrored too,
because friction and force ripple vary along the guide: what fits one half of it can be wrong on
the other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter, ss2tf

from stickslip.identification.stages.estimate import correlation_length
from stickslip.servo.measurement import Array, smoothed
from stickslip.servo.paper_commands import SLOW
from stickslip.servo.systems import feedforward
from stickslip.tuning.learning import BOUNDS, Study, VelocityCost

FLOOR = 0.01
"""Least relative error granted to identification: its models are not exact either."""
REPEATS = 5
JITTER = 1e-4
"""Relative change of the parameters between repeated runs."""


@dataclass(frozen=True)
class Runs:
    """Repeated runs of one compensator.

    Attributes
    ----------
    values : its parameters by name, in SI units
    gaps : (2, REPEATS, n) v - v_r [m/s] of the training command and of its mirror image
    slow : cost of a slower command [m^2/s^2], which is for comparison and not fitted
    """

    values: Mapping[str, float]
    gaps: Array
    slow: float

    @cached_property
    def gap(self) -> Array:
        """The mean of the repeated runs (2, n) [m/s], without most of the noise."""
        return np.asarray(self.gaps.mean(axis=1))

    @cached_property
    def cost(self) -> float:
        """The mean cost of the training command and its mirror image [m^2/s^2]."""
        return float((self.gaps**2).sum(axis=2).mean())

    @cached_property
    def training_cost(self) -> float:
        """The median cost of the training command [m^2/s^2]."""
        return float(np.median((self.gaps[0] ** 2).sum(axis=1)))


class Bench:
    """Runs a compensator several times, a little changed, as no drive runs twice alike."""

    def __init__(self, study: Study) -> None:
        slow = SLOW.sample(study.rig.samples(SLOW.duration))
        commands = (study.v_cmd, -study.v_cmd, slow)
        self._studies = [replace(study, v_cmd=v_cmd) for v_cmd in commands]
        self._rng = np.random.default_rng(study.seed)
        self.runs = 0

    def run(self, values: Mapping[str, float]) -> Runs:
        """Run the training command, its mirror image and a slow one."""
        *gaps, slow = (self._gaps(study, values) for study in self._studies)
        return Runs(dict(values), np.array(gaps), float((slow**2).sum(axis=1).mean()))

    def _gaps(self, study: Study, values: Mapping[str, float]) -> Array:
        """Return v - v_r (REPEATS, n) [m/s]."""
        criterion, gaps = VelocityCost(study.rig.T_s), []
        with study.rig.trials(study.v_cmd, study.loop, study.feed) as run:
            for _ in range(REPEATS):
                self.runs += 1
                change = np.exp(JITTER * self._rng.standard_normal(len(study.start)))
                changed = np.array([values[name] for name in study.start]) * change
                gaps.append(criterion.gap(run(study.parameters(changed))))
        return np.array(gaps)


@dataclass(frozen=True)
class Fit:
    """What least squares make of runs.

    Attributes
    ----------
    values : the parameters by name, in SI units
    errors : their relative standard errors
    alone : what those would be without the start's own
    cost : of such runs with these parameters, as the fit expects it [m^2/s^2]
    """

    values: dict[str, float]
    errors: dict[str, float]
    alone: dict[str, float]
    cost: float


def fit(study: Study, runs: Runs, *, prior: bool = True) -> Fit:
    """Fit the parameters to runs and, with ``prior``, to the study's start.

    The start enters with its standard errors, as further equations.
    """
    names, space = tuple(study.start), study.space
    # The variables of the fit are the coordinates of the law's parameters, all of them logarithms.
    to_logs = np.array([space.direction(name)[: len(names)] for name in names])
    ratios = [space.index(name) for name in space.bounded]
    expected = np.log([study.start[name].value for name in names])
    doubt = np.array([_relative_error(study, name) for name in names])
    power = [gap @ gap / len(gap) * correlation_length(gap) for gap in runs.gap]
    scale = np.sqrt(np.mean(power))
    numerator, denominator = _transfer(study)
    system = feedforward(study.rig.fmus, study.loop, {}, study.feed)
    stop = (len(study.v_cmd) - 1) * study.rig.T_s
    with system.prepare(step=study.rig.T_s, stop=stop, record=["compensator.F_mean"]) as simulation:

        def force(logs: Array) -> Array:
            """Return the compensator's force (2, n) [N] for each command."""
            values = {f"compensator.{n}": v for n, v in study.parameters(np.exp(logs)).items()}
            commands = (study.v_cmd, -study.v_cmd)
            results = [simulation.run(values, study.loop.commands(v_cmd)) for v_cmd in commands]
            return np.array([result["compensator.F_mean"] for result in results])

        begin = np.log([runs.values[name] for name in names])
        applied = force(begin)

        def gap(q: Array) -> Array:
            # The force of row n + 1 acts from t[n] on.
            change = np.pad((force(to_logs @ q) - applied)[:, 1:], ((0, 0), (0, 1)))
            moved = [smoothed(lfilter(numerator, denominator, c), study.rig.T_s) for c in change]
            return np.asarray(runs.gap + np.array(moved))

        def residual(q: Array) -> Array:
            known = (to_logs @ q - expected) / doubt
            return np.concatenate([gap(q).ravel() / scale, known if prior else []])

        low, high = np.log(BOUNDS)
        low_q, high_q = expected + low, expected + high
        low_q[ratios], high_q[ratios] = 0.0, high - low
        q = np.clip(np.linalg.solve(to_logs, begin), low_q + 1e-9, high_q - 1e-9)
        found = least_squares(
            residual,
            q,
            bounds=(low_q, high_q),
            x_scale="jac",
            diff_step=[1e-4],
            ftol=1e-5,
            xtol=1e-5,
        )
        left = gap(found.x)
    jacobian = found.jac @ np.linalg.inv(to_logs)
    commands, n = left.shape
    return Fit(
        values=study.parameters(np.exp(to_logs @ found.x)),
        errors=study.parameters(_errors(jacobian)),
        alone=study.parameters(_errors(jacobian[: commands * n])),
        cost=runs.cost + float(((left**2).sum() - (runs.gap**2).sum()) / commands),
    )


def _relative_error(study: Study, name: str) -> float:
    known = study.start[name]
    return max(known.standard_error / known.value, FLOOR)


def _errors(jacobian: Array) -> Array:
    """Return relative standard errors (k,) from the Jacobian of residuals by logarithms."""
    information = jacobian.T @ jacobian + 1e-12 * np.eye(jacobian.shape[1])
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))))


def _transfer(study: Study) -> tuple[Array, Array]:
    """Return numerator and denominator from feedforward force [N] to velocity [m/s]."""
    loop = study.loop.compliance
    numerator, denominator = ss2tf(loop.A, loop.B, loop.C, loop.D)
    return numerator[0], denominator
