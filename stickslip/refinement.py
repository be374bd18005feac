"""The end of the learning: what the training run shows, weighed against what identification knew.

The cost sees some parameters well and others hardly; left to the genetic algorithm the latter end
anywhere. From one more recording of the best candidate follows how the gap v - v_r would change
with the compensator's force (the loop is linear in it), so a least-squares fit of the five
parameters needs no further runs. Identification enters with its standard errors, as further
equations of the same fit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter, ss2tf

from stickslip.identification.estimate import Estimate, correlation_length
from stickslip.learning import BOUNDS, Study, VelocityCost, parameters
from stickslip.loop import feedforward
from stickslip.measurement import Array, smoothed
from stickslip.parameters import LUGRE

FLOOR = 0.01
"""Least relative error granted to identification: its models are not exact either."""
ROUNDS = 2
REPEATS = 5
JITTER = 1e-4
"""Relative change of the parameters between repeated runs."""
MARGIN = 0.1
"""By how much a fit may cost more than the winner: the scatter of typical runs."""

# The fit's variables are logarithms of F_s / F_c, F_c, v_s, sigma_0, sigma_1; the first is >= 0.
_TO_LOGS = np.eye(5)
_TO_LOGS[0, 1] = 1.0


@dataclass(frozen=True)
class Refinement:
    """What is known after learning.

    Attributes
    ----------
    estimates : the five parameters with standard errors, in SI units
    alone : relative standard error that the training run alone would leave, by name
    cost : of a typical run on the drive [m^2/s^2]
    accepted : whether the fit did as well on the drive as the candidate it began with
    runs : further runs of the drive that it took
    """

    estimates: dict[str, Estimate]
    alone: dict[str, float]
    cost: float
    accepted: bool
    runs: int

    @property
    def values(self) -> dict[str, float]:
        """The parameters by name, in SI units."""
        return {name: estimate.value for name, estimate in self.estimates.items()}


def refine(study: Study, start: Mapping[str, float], *, fit: bool = True) -> Refinement:
    """Fit the parameters to the training run and to identification, beginning at ``start``.

    The drive has the last word: a fit that costs more there than ``start`` is not taken. Both are
    judged by their typical run, because the winner of hundreds of runs owes much to luck. With
    ``fit`` False, ``start`` is only judged.
    """
    bench = _Bench(study)
    values, gap = dict(start), bench.typical_gap(start)
    limit = (1.0 + MARGIN) * (gap @ gap)
    identified = {name: study.start[name].value for name in LUGRE}
    accepted = False
    # Where the winner lies too far off for the linear step, identification lies nearer.
    for origin in (values, identified) if fit else ():
        proposal = origin
        for _ in range(ROUNDS):
            proposal = _fit(study, proposal, bench.typical_gap(proposal)).values
        trial = bench.typical_gap(proposal)
        if trial @ trial <= limit:
            values, gap, accepted = proposal, trial, True
            break
    final = _fit(study, values, gap)
    errors = final.errors if accepted else final.alone
    estimates = {name: Estimate(values[name], values[name] * errors[name]) for name in LUGRE}
    return Refinement(estimates, final.alone, float(gap @ gap), accepted, bench.runs)


class _Bench:
    """Runs a compensator several times, a little changed, as no drive runs twice alike."""

    def __init__(self, study: Study) -> None:
        self._study = study
        self._judge = VelocityCost(study.rig.T_s)
        self._rng = np.random.default_rng(study.seed)
        self.runs = 0

    def typical_gap(self, values: Mapping[str, float]) -> Array:
        """Return v - v_r (n,) [m/s] of the run whose cost is the median."""
        gaps = []
        for _ in range(REPEATS):
            change = np.exp(JITTER * self._rng.standard_normal(len(LUGRE)))
            changed = np.array([values[name] for name in LUGRE]) * change
            gaps.append(self._judge.gap(self._study.run(parameters(changed))))
        self.runs += REPEATS
        return sorted(gaps, key=lambda gap: float(gap @ gap))[REPEATS // 2]


@dataclass(frozen=True)
class _Fit:
    values: dict[str, float]
    errors: dict[str, float]  # relative
    alone: dict[str, float]  # relative, without identification


def _fit(study: Study, start: Mapping[str, float], gap: Array) -> _Fit:
    prior = study.start
    expected = np.log([prior[name].value for name in LUGRE])
    doubt = np.array([max(prior[name].standard_error / prior[name].value, FLOOR) for name in LUGRE])
    scale = np.sqrt(gap @ gap / len(gap) * correlation_length(gap))
    system = feedforward(study.rig.fmus, study.loop, {}, study.feed)
    numerator, denominator = _transfer(study)
    with system.prepare(
        step=study.rig.T_s,
        stop=(len(study.v_cmd) - 1) * study.rig.T_s,
        record=["compensator.F_mean"],
    ) as simulation:

        def force(logs: Array) -> Array:
            values = {f"compensator.{n}": v for n, v in parameters(np.exp(logs)).items()}
            return simulation.run(values, {"v_cmd": study.v_cmd})["compensator.F_mean"]

        begin = np.log([start[name] for name in LUGRE])
        applied = force(begin)

        def residual(q: Array) -> Array:
            logs = _TO_LOGS @ q
            # The force of row n + 1 acts from t[n] on.
            change = np.append((force(logs) - applied)[1:], 0.0)
            moved = smoothed(lfilter(numerator, denominator, change), study.rig.T_s)
            return np.concatenate([(gap + moved) / scale, (logs - expected) / doubt])

        low, high = np.log(BOUNDS)
        low_q, high_q = expected + low, expected + high
        low_q[0], high_q[0] = 0.0, high - low
        q = np.clip(np.linalg.solve(_TO_LOGS, begin), low_q + 1e-9, high_q - 1e-9)
        fit = least_squares(residual, q, bounds=(low_q, high_q), x_scale="jac", diff_step=[1e-4])
    logs = _TO_LOGS @ fit.x
    jacobian = fit.jac @ np.linalg.inv(_TO_LOGS)
    return _Fit(
        values=parameters(np.exp(logs)),
        errors=_errors(jacobian),
        alone=_errors(jacobian[: len(gap)]),
    )


def _errors(jacobian: Array) -> dict[str, float]:
    """Return relative standard errors from a Jacobian in logarithms, residuals in deviations."""
    information = jacobian.T @ jacobian + 1e-12 * np.eye(len(LUGRE))
    return parameters(np.sqrt(np.diag(np.linalg.inv(information))))


def _transfer(study: Study) -> tuple[Array, Array]:
    """Return numerator and denominator from feedforward force [N] to velocity [m/s]."""
    loop = study.loop.compliance
    numerator, denominator = ss2tf(loop.A, loop.B, loop.C, loop.D)
    return numerator[0], denominator
