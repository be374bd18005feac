"""Tuning of an entrant on a drive, from its encoder and its motor force.

Every entrant has the same command, the same algorithm and the same budget: so many evaluations, and
so many seconds of motion of the drive. A candidate whose linear loop has a peak sensitivity above
the limit is not run.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from stickslip import cosim, ga
from stickslip.compensators.entrants import SPEED, Coarse, Entrant, TunedEntrant, entrant
from stickslip.servo.axis import ControlError, Datasheet
from stickslip.servo.chain_response import ChainResponse, Robustness
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.studies.arena.budget import Budget
from stickslip.studies.arena.course import Course
from stickslip.studies.arena.motion_commands import Training, moves, sweep
from stickslip.thresholds import offer
from stickslip.tuning.learning import VelocityCost

SLIDING = 0.5  # Share of the largest speed of the command above which the drive slides
NEAR = 1.05  # A cost of at most so many times that at the end counts as tuned


@dataclass(frozen=True)
class TuningResult:
    """An entrant as it was tuned."""

    genes: Mapping[str, float]  # values by name; empty where nothing is tuned
    learned: Mapping[str, float]  # parameters that it learned while it ran
    coarse: Coarse  # what the drive showed before
    # RMS of v - v_r in the counted part of the training command [m/s]; of x - x_cmd [m] where the
    # entrant controls the position
    cost: float
    evaluations: int  # candidates that were evaluated
    seconds: float  # of motion of the drive that were used [s]
    soon: float  # seconds of motion after which the cost was within ``NEAR`` of that at the end [s]

    def tuned(self, entrant: Entrant, loop: VelocityLoop, sheet: Datasheet) -> TunedEntrant:
        """Return what it found, to be validated in a loop: nothing is learned any more."""
        tuned = entrant.tuned(self.genes, loop, self.coarse, sheet)
        return replace(tuned, parameters={**tuned.parameters, **self.learned, **entrant.frozen})


def measure(fmus: Path, loop: VelocityLoop, v_cmd: Array, seed: int) -> Coarse:
    """Return the friction that a drive shows in one run of a command (n,) [m/s]."""
    with Course(fmus, loop, entrant("none"), len(v_cmd), ("drive.F_m",)) as course:
        F_m = course.run(TunedEntrant(loop, {}), v_cmd)["drive.F_m"]
    speed = float(np.abs(v_cmd).max())
    moving = np.abs(v_cmd) > SLIDING * speed
    inert = loop.axis.m * np.gradient(v_cmd, loop.T_s) + loop.axis.b * v_cmd
    friction = np.median((np.sign(v_cmd) * (F_m - inert))[moving])
    return Coarse(max(float(friction), 1e-3 * float(np.abs(F_m).max())), speed, seed)


def tune(
    fmus: Path,
    loop: VelocityLoop,
    one: Entrant,
    budget: Budget,
    seed: int,
    sheet: Datasheet,
    speed: float = SPEED,
) -> TuningResult:
    """Tune an entrant on the drive in a folder of FMUs, at a speed [m/s].

    Raises NothingLearned when no candidate of the first generation can be run within the limit of
    Ms.
    """
    factor = speed / SPEED
    coarse = measure(fmus, loop, sweep(loop.T_s, factor).v_cmd, seed)
    motion = moves(loop.T_s, factor) if one.positions else sweep(loop.T_s, factor)
    v_cmd, base = motion.v_cmd, one.base(loop)
    problem = one.problem(coarse)
    variables = one.learned
    with (
        ChainResponse(fmus, loop, one.chain) as response,
        Course(fmus, base, one, len(v_cmd), ("drive.x_enc", "nominal.v_r")) as course,
    ):
        trial = _Trial(one, loop, course, response, coarse, motion, sheet)
        genes: dict[str, float] = {}
        if problem is not None:
            limits = ga.Limits(evaluations=budget.runs(trial.duration))
            algorithm = ga.optimiser("default", problem, limits, seed=seed)
            genes = ga.learn(algorithm, trial).parameters
        tuned = one.tuned(genes, loop, coarse, sheet)
        robust = trial.robustness(tuned)
        cost = trial.error(tuned, robust)
    learned: dict[str, float] = {}
    if variables:
        record = cosim.Record(tuple(variables.values()), keep="last")
        with Course(fmus, base, one, len(v_cmd), record) as course:
            last = course.run(tuned, v_cmd)
            learned = {name: float(last[shown][-1]) for name, shown in variables.items()}
    spent = np.cumsum(np.isfinite(trial.costs)) * trial.duration
    near = np.array(trial.costs) <= NEAR * min(trial.costs, default=0.0)
    seconds, soon = (spent[-1], spent[np.argmax(near)]) if len(spent) else (0.0, 0.0)
    evaluations = len(trial.costs)
    return TuningResult(genes, learned, coarse, cost, evaluations, float(seconds), float(soon))


class _Trial:
    """The cost of a candidate: RMS of v - v_r [m/s], as measured and by noise.

    Where the entrant controls the position, RMS of x - x_cmd [m] in the rests of small moves.

    An observer that makes the drive follow the steps of its encoder seems to track well, because
    the encoder shows it so. What the noise of the encoder adds to the true velocity is therefore
    computed, from the linear loop, and counts as well.
    """

    fatal = (cosim.CosimError,)

    def __init__(
        self,
        one: Entrant,
        loop: VelocityLoop,
        course: Course,
        response: ChainResponse,
        coarse: Coarse,
        motion: Training,
        sheet: Datasheet,
    ) -> None:
        self.one, self.loop, self.course, self.response = one, loop, course, response
        self.coarse, self.motion, self.sheet = coarse, motion, sheet
        problem = one.problem(coarse)
        self.names = problem.names if problem else []
        self.criterion = VelocityCost(loop.T_s)
        self.duration = len(motion.v_cmd) * loop.T_s
        self.costs: list[float] = []

    def __call__(self, values: Array) -> float:
        """Return the cost of a candidate (k,).

        Raises CandidateFailed when its loop is unstable or above the limit of Ms, or the run fails.
        """
        self.costs.append(float("inf"))
        try:
            tuned = self.tuned(values)
            robust = self.robustness(tuned)
        except ControlError as error:
            raise ga.CandidateFailed(str(error)) from error
        if not robust.peak <= offer.SENSITIVITY:
            raise ga.CandidateFailed(
                f"Ms = {robust.peak:.3g}, expected at most {offer.SENSITIVITY:g}"
            )
        self.costs[-1] = self.error(tuned, robust)
        return self.costs[-1]

    def robustness(self, tuned: TunedEntrant) -> Robustness:
        """Return how robust the linear loop is."""
        return tuned.robustness(self.response, self.coarse.friction)

    def tuned(self, values: Array) -> TunedEntrant:
        """Return the entrant with the values (k,) of a candidate."""
        genes = dict(zip(self.names, values.tolist(), strict=True))
        return self.one.tuned(genes, self.loop, self.coarse, self.sheet)

    def error(self, tuned: TunedEntrant, robust: Robustness) -> float:
        """Return the error of a run [m/s], or [m]."""
        v_cmd, counted = self.motion.v_cmd, self.motion.counted
        try:
            result = self.course.run(tuned, v_cmd)
        except cosim.SimulationError as error:
            raise ga.CandidateFailed(str(error)) from error
        if self.one.positions:
            gap = result["drive.x_enc"] - tuned.loop.commands(v_cmd)["x_cmd"]
            return float(np.sqrt(np.mean(gap[counted] ** 2)))
        square = np.mean(self.criterion.gap(result)[counted] ** 2)
        noise = robust.noise * self.sheet.encoder_step
        return float(np.sqrt(square + noise**2 / 12.0))
