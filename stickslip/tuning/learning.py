"""What learning the friction on a drive needs: the study, the cost (6), and the genes of Fig. 3.

Least squares on recorded runs of the drive: which parameters would have left the smallest gap.

The loop is linear in the compensator's force, so from recorded runs follows how the gap v - v_r
would change with the parameters; the fit needs no further runs. Runs are repeated, because the
encoder's steps pass through the loop differently each time, and the command is run mirrored too,
because friction and force ripple vary along the guide: what fits one half of it can be wrong on the
other. Runs of further commands enter alike.

Cost is the sum in (6), of v - v_r over the training run: v as the encoder shows it, v_r from the
nominal loop, both through the same low-pass.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import lfilter, ss2tf

from stickslip import ga
from stickslip.catalog.parameters import (
    ParameterSpace,
    correlation_length,
    estimated,
    friction_law,
    unit_of,
)
from stickslip.identification.stages import Estimate
from stickslip.rigs.contract import Rig, TrialLog
from stickslip.servo.measurement import Array, smoothed
from stickslip.servo.systems import feedforward
from stickslip.servo.velocity_loop import VelocityLoop

_LAW = friction_law()
SPREAD = {name: _LAW.parameters[name].spread or 0.0 for name in estimated(_LAW)}
"""Standard deviation of the natural logarithm of each factor, from law.toml: "coarsely".

Forces to 20 %, as single slow runs show them; the two presliding parameters to a factor of 1.4;
the Stribeck velocity, which no single experiment isolates, to a factor of 2.
"""


def draw_factors(seed: int) -> dict[str, float]:
    """Draw log-normal factors by name, as accurate as ``SPREAD``."""
    rng = np.random.Generator(np.random.PCG64(seed))
    logs = rng.standard_normal(len(SPREAD)) * list(SPREAD.values())
    return dict(zip(SPREAD, np.exp(logs).tolist(), strict=True))


def coarsened(
    estimates: Mapping[str, Estimate], factors: Mapping[str, float]
) -> dict[str, Estimate]:
    """Return the estimates of LuGre's parameters times factors, with standard errors of ``SPREAD``.

    The paper identifies its drive "coarsely" and does not say how coarsely. Here the three
    experiments find Coulomb friction to 0.02 %, so there is nothing to learn. A coarse start
    multiplies what they found by factors, which stand for experiments of a stated accuracy.

    Static friction below Coulomb friction, which no experiment would report, is exchanged with it.
    A factor that is missing is 1.
    """
    values = {name: estimates[name].value * factors.get(name, 1.0) for name in SPREAD}
    for name, bound in ParameterSpace.of(_LAW).bounded.items():
        values[bound], values[name] = sorted((values[bound], values[name]))
    return {name: Estimate(value, SPREAD[name] * value) for name, value in values.items()}


BOUNDS = (0.1, 100.0)  # times the identified value, as in the paper


@dataclass(frozen=True)
class VelocityCost:
    """Sum of (v - v_r)^2 [m^2/s^2] over the samples of a run on the drive."""

    T_s: float  # sample period [s]

    def __call__(self, result: TrialLog) -> float:
        """Return the cost of the recorded ``drive.x_enc`` [m] and ``nominal.v_r`` [m/s]."""
        gap = self.gap(result)
        return float(np.sum(gap * gap))  # the same bits whatever the threads of the linear algebra

    def gap(self, result: TrialLog) -> Array:
        """Return v - v_r (n,) [m/s]."""
        v = np.gradient(result["drive.x_enc"], self.T_s)
        return smoothed(v - result["nominal.v_r"], self.T_s)


@dataclass(frozen=True)
class Study:
    """What a learning run needs, and nothing of the drive but its rig."""

    rig: Rig
    loop: VelocityLoop  # the velocity loop of the drive, and its nominal loop
    # the compensator's tuned parameters by name, in the order of law.toml, with the standard errors
    # of their identification, SI units
    start: Mapping[str, Estimate]
    v_cmd: Array  # (n,) training command [m/s], one value a sample
    seed: int = 0  # of the small changes between repeated runs

    @cached_property
    def space(self) -> ParameterSpace:
        """The coordinates of the compensator's parameters."""
        return ParameterSpace.of(self.rig.law)

    def parameters(self, values: Array) -> dict[str, float]:
        """Return the genes' values (k,) by name."""
        return dict(zip(self.start, values.tolist(), strict=True))

    def cost_without(self) -> float:
        """Return the cost of the training run without compensation [m^2/s^2]."""
        values = {name: one.value for name, one in self.start.items()}  # any
        with self.rig.trials(self.v_cmd, self.loop, compensated=False) as run:
            return VelocityCost(self.rig.T_s)(run(values))


def genes(start: Mapping[str, Estimate]) -> list[ga.Gene]:
    """Return the genes: identified values to start from, and the bounds of the paper."""
    low, high = BOUNDS
    return [
        ga.Gene(name, low * one.value, high * one.value, one.value, unit=unit_of(name))
        for name, one in start.items()
    ]


FLOOR = 0.01  # least relative error granted to identification: its models are not exact either
REPEATS = 5
JITTER = 1e-4  # relative change of the parameters between repeated runs


@dataclass(frozen=True)
class Runs:
    """Repeated runs of one compensator."""

    values: Mapping[str, float]  # its parameters by name, in SI units
    commands: Sequence[Array]  # the training command, its mirror image, and further ones (n,) [m/s]
    gaps: Sequence[Array]  # (REPEATS, n) v - v_r [m/s] of each

    @cached_property
    def means(self) -> list[Array]:
        """The mean of the repeated runs (n,) [m/s] of each command, without most of the noise."""
        return [gaps.mean(axis=0) for gaps in self.gaps]

    @cached_property
    def cost(self) -> float:
        """The mean cost of the training command and its mirror image [m^2/s^2]."""
        return float(np.mean([(gaps**2).sum(axis=1) for gaps in self.gaps[:2]]))

    @cached_property
    def training_cost(self) -> float:
        """The median cost of the training command [m^2/s^2]."""
        return float(np.median((self.gaps[0] ** 2).sum(axis=1)))


class Bench:
    """Runs compensators on the training command, its mirror image, and further commands."""

    def __init__(self, study: Study, *further: Array) -> None:
        self._studies = [
            replace(study, v_cmd=v_cmd) for v_cmd in (study.v_cmd, -study.v_cmd, *further)
        ]
        self._rng = np.random.default_rng(study.seed)
        self.runs = 0

    def run(self, values: Mapping[str, float]) -> Runs:
        """Run every command several times, a little changed, as no drive runs twice alike."""
        gaps = [self._gaps(study, values) for study in self._studies]
        return Runs(dict(values), [study.v_cmd for study in self._studies], gaps)

    def _gaps(self, study: Study, values: Mapping[str, float]) -> Array:
        """Return v - v_r (REPEATS, n) [m/s]."""
        criterion, gaps = VelocityCost(study.rig.T_s), []
        with study.rig.trials(study.v_cmd, study.loop) as run:
            for _ in range(REPEATS):
                self.runs += 1
                change = np.exp(JITTER * self._rng.standard_normal(len(study.start)))
                changed = np.array([values[name] for name in study.start]) * change
                gaps.append(criterion.gap(run(study.parameters(changed))))
        return np.array(gaps)


@dataclass(frozen=True)
class Fit:
    """What least squares make of runs."""

    values: dict[str, float]  # the parameters by name, in SI units
    errors: dict[str, float]  # their relative standard errors
    alone: dict[str, float]  # what the training command and its mirror image alone would leave


def fit(study: Study, runs: Runs) -> Fit:
    """Fit the parameters to runs and, weighted by its standard errors, to the study's start."""
    names, space = tuple(study.start), study.space
    # The variables of the fit are the coordinates of the law's parameters, all of them logarithms.
    to_logs = np.array([space.direction(name)[: len(names)] for name in names])
    ratios = [space.index(name) for name in space.bounded]
    expected = np.log([study.start[name].value for name in names])
    doubt = np.array([max(one.standard_error / one.value, FLOOR) for one in study.start.values()])
    power = [gap @ gap / len(gap) * correlation_length(gap) for gap in runs.means]
    scale = np.sqrt(np.mean(power))
    loop = study.loop.compliance  # from feedforward force [N] to velocity [m/s]
    (numerator,), denominator = ss2tf(loop.A, loop.B, loop.C, loop.D)
    system = feedforward(study.rig.fmus, study.loop, {})
    T_s = study.rig.T_s
    longest = max(map(len, runs.commands))
    stop = (longest - 1) * T_s
    with system.prepare(step=T_s, stop=stop, record=["compensator.F_mean"]) as simulation:

        def force(logs: Array) -> list[Array]:
            """Return the compensator's force (n,) [N] for each command."""
            values = {f"compensator.{n}": v for n, v in study.parameters(np.exp(logs)).items()}
            found = []
            for v_cmd in runs.commands:
                padded = study.loop.commands(np.pad(v_cmd, (0, longest - len(v_cmd)), mode="edge"))
                result = simulation.run(values, padded, until=(len(v_cmd) - 1) * T_s)
                found.append(result["compensator.F_mean"][: len(v_cmd)])
            return found

        begin = np.log([runs.values[name] for name in names])
        applied = force(begin)

        def gap(q: Array) -> list[Array]:
            left = []
            for before, now, then in zip(runs.means, force(to_logs @ q), applied, strict=True):
                change = np.append((now - then)[1:], 0.0)  # of row n + 1 acts from t[n] on
                left.append(before + smoothed(lfilter(numerator, denominator, change), T_s))
            return left

        def residual(q: Array) -> Array:
            known = (to_logs @ q - expected) / doubt
            return np.concatenate([np.concatenate(gap(q)) / scale, known])

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
    training = sum(map(len, left[:2]))
    return Fit(
        values=study.parameters(np.exp(to_logs @ found.x)),
        errors=study.parameters(_errors(jacobian)),
        alone=study.parameters(_errors(jacobian[:training])),
    )


def _errors(jacobian: Array) -> Array:
    """Return relative standard errors (k,) from the Jacobian of residuals by logarithms."""
    information = jacobian.T @ jacobian + 1e-12 * np.eye(jacobian.shape[1])
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(information))))
