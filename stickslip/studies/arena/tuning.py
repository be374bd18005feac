"""Tuning of an entrant on a drive, from its encoder and its motor force.

Every entrant has the same commands, the same algorithm and the same budget: so many evaluations,
and so many seconds of motion of the drive. A candidate whose linear loop has a peak sensitivity
above the limit is not run. The cost is what validation ranks by, on other motions and as the
encoder shows it: the geometric mean over the kinds of motion of the errors against the command.
"""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from stickslip import cosim, ga
from stickslip.compensators.entrants import SPEED, Coarse, Entrant, TunedEntrant, entrant
from stickslip.evaluation.motions import TRAINING as SWEEP
from stickslip.identification.stages import identify
from stickslip.rigs.contract import Command as RigCommand
from stickslip.rigs.contract import Log
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.axis import LOOP, ControlError, Datasheet
from stickslip.servo.chain_response import ChainResponse, Robustness
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop, position_loop
from stickslip.studies.arena import Budget
from stickslip.studies.arena.course import Course
from stickslip.studies.arena.metrics import ERROR, MEASURES, Trace
from stickslip.studies.arena.motion_commands import LEARNING, TRAINING, Command
from stickslip.thresholds import offer
from stickslip.tuning.learning import Study
from stickslip.tuning.refinement import refine

SLIDING = 0.5  # Share of the largest speed of the command above which the drive slides
NEAR = 1.05  # A cost of at most so many times that at the end counts as tuned


@dataclass(frozen=True)
class TuningResult:
    """An entrant as it was tuned."""

    genes: Mapping[str, float]  # values by name; empty where nothing is tuned
    learned: Mapping[str, float]  # parameters that it learned while it ran
    coarse: Coarse  # what the drive showed before
    cost: float  # geometric mean of the errors, relative to those without compensation
    evaluations: int  # candidates that were evaluated
    seconds: float  # of motion of the drive that were used [s]
    soon: float  # seconds of motion after which the cost was within ``NEAR`` of that at the end [s]

    @classmethod
    def read(cls, document: Mapping[str, Any]) -> "TuningResult":
        """Return one from its document."""
        return cls(**{**document, "coarse": Coarse(**document["coarse"])})

    def tuned(self, entrant: Entrant, loop: VelocityLoop, sheet: Datasheet) -> TunedEntrant:
        """Return what it found, to be validated in a loop: nothing is learned any more."""
        tuned = entrant.tuned(self.genes, loop, self.coarse, sheet)
        return with_learned(tuned, entrant, self.learned)


def with_learned(
    tuned: TunedEntrant, entrant: Entrant, learned: Mapping[str, float]
) -> TunedEntrant:
    """Return an entrant with what it learned, that learns no more."""
    return replace(tuned, parameters={**tuned.parameters, **learned, **entrant.frozen})


def measure(
    fmus: Path, loop: VelocityLoop, seed: int, sheet: Datasheet, commands: Sequence[Command]
) -> tuple[Coarse, dict[str, float]]:
    """Return the friction that a drive shows without compensation, and its error by command."""
    plain = entrant("none")
    first = commands[0]
    v_cmd = first.sample(loop.T_s)
    with Course(fmus, loop, plain, len(v_cmd), ("drive.F_m",)) as course:
        F_m = course.run(TunedEntrant(loop, {}), v_cmd)["drive.F_m"]
    speed = float(np.abs(v_cmd).max())
    moving = np.abs(v_cmd) > SLIDING * speed
    inert = loop.axis.m * np.gradient(v_cmd, loop.T_s) + loop.axis.b * v_cmd
    friction = np.median((np.sign(v_cmd) * (F_m - inert))[moving])
    coarse = Coarse(max(float(friction), 1e-3 * float(np.abs(F_m).max())), speed, seed)
    with Courses(fmus, loop, plain, commands, sheet) as courses:
        return coarse, courses.errors(TunedEntrant(loop, {}), 0.0)


class Courses(ExitStack):
    """The training motions of an entrant, in the velocity loop and in a position loop."""

    def __init__(
        self,
        fmus: Path,
        loop: VelocityLoop,
        one: Entrant,
        commands: Sequence[Command],
        sheet: Datasheet,
        factor: float = 1.0,  # on the speeds
    ) -> None:
        super().__init__()
        self.one, self.commands, self._step = one, commands, sheet.encoder_step
        self._sampled = {command.name: command.sample(loop.T_s) for command in commands}
        teaching = LEARNING.scaled(factor).sample(loop.T_s) if one.learned else np.empty(0)
        runs = [teaching, *self._sampled.values()]
        self.duration = sum(map(len, runs)) * loop.T_s
        base, self._courses = one.base(loop), dict[bool, Course]()
        for position in (False, True):
            own = [self._sampled[c.name] for c in commands if c.position == position]
            around = base if one.positions or not position else position_loop(base)
            course = Course(fmus, around, one, max(map(len, own)), ("drive.x_enc",))
            self._courses[position] = self.enter_context(course)
        self._teaching, self._learning = teaching, None
        if one.learned:
            record = cosim.Record(tuple(one.learned.values()), keep="last")
            course = Course(fmus, base, one, len(teaching), record)
            self._learning = self.enter_context(course)

    def learned(self, tuned: TunedEntrant) -> dict[str, float]:
        """Return what an entrant learns while it runs, by the parameters that take it."""
        if self._learning is None:
            return {}
        last = self._learning.run(tuned, self._teaching)
        return {name: float(last[shown][-1]) for name, shown in self.one.learned.items()}

    def errors(self, tuned: TunedEntrant, noise: float) -> dict[str, float]:
        """Return the error by command, as the encoder shows it.

        An entrant has learned before, and learns no more. To an error of the velocity adds what
        noise of the encoder adds to the true one, RMS [m/s]: an observer that makes the drive
        follow the steps of its encoder seems to track well. What an encoder does not resolve is no
        error of the position.

        Raises SimulationError when an FMU fails.
        """
        found, fixed = dict[str, float](), with_learned(tuned, self.one, self.learned(tuned))
        around = fixed.loop.changed(K_x=self._courses[True].loop.K_x)
        outer = fixed if self.one.positions else replace(fixed, loop=around)
        for command in self.commands:
            course, v_cmd = self._courses[command.position], self._sampled[command.name]
            x_enc = np.asarray(
                course.run(outer if command.position else fixed, v_cmd)["drive.x_enc"][: len(v_cmd)]
            )
            trace = Trace.measured(course.loop.T_s, v_cmd, x_enc, self._step)
            error, _ = MEASURES[command.kind](command, trace)[ERROR]
            if command.position:
                error = max(error, self._step / np.sqrt(12.0))
            else:
                speeds = [command.relative.get(name, 1.0) for name in command.counted]
                error = np.hypot(error, noise * np.sqrt(np.mean(np.power(speeds, -2.0))))
            found[command.name] = float(error)
        return found


def tune(
    fmus: Path,
    loop: VelocityLoop,
    one: Entrant,
    budget: Budget,
    seed: int,
    sheet: Datasheet,
    speed: float = SPEED,
) -> TuningResult:
    """Tune an entrant on a drive at a speed [m/s]; raise NothingLearned where Ms allows nothing."""
    commands = [command.scaled(speed / SPEED) for command in TRAINING]
    coarse, plain = measure(fmus, loop, seed, sheet, commands)
    shown, spent = _experiments(fmus, loop, one, sheet, seed)
    problem = one.problem(coarse)
    with (
        ChainResponse(fmus, loop, one.chain) as response,
        Courses(fmus, loop, one, commands, sheet, factor=speed / SPEED) as courses,
    ):
        trial = _Trial(one, loop, courses, response, coarse, plain, sheet, shown=shown)
        genes: dict[str, float] = {}
        if problem is not None:
            left = replace(budget, seconds=max(budget.seconds - spent, 0.0))
            limits = ga.Limits(evaluations=left.runs(courses.duration))
            algorithm = ga.optimiser("default", problem, limits, seed=seed)
            genes = ga.learn(algorithm, trial).parameters
        tuned = trial.tuned_by(genes)
        cost = trial.error(tuned, trial.robustness(tuned))
        learned = {**shown, **courses.learned(tuned)}
    used = spent + np.cumsum(np.isfinite(trial.costs)) * courses.duration
    near = np.array(trial.costs) <= NEAR * min(trial.costs, default=0.0)
    seconds, soon = (used[-1], used[np.argmax(near)]) if len(used) else (spent, spent)
    evaluations = len(trial.costs)
    return TuningResult(genes, learned, coarse, cost, evaluations, float(seconds), float(soon))


class _Rig(FmuRig):
    """A drive that counts its motion."""

    seconds = 0.0

    def move(self, command: RigCommand) -> Log:
        self.seconds += len(command) * self.T_s
        return super().move(command)


def _experiments(
    fmus: Path, loop: VelocityLoop, one: Entrant, sheet: Datasheet, seed: int
) -> tuple[dict[str, float], float]:
    """Return what parts learn by experiments on a rig of the drive, and their motion [s]."""
    found, seconds = dict[str, float](), 0.0
    for part in one.parts:
        if not part.experiment or part.law is None:
            continue
        rig = _Rig(fmus, sheet, loop.T_s, part.law.name)
        known = identify(rig, LOOP).tuned
        if part.experiment == "fitted":
            v_cmd = SWEEP.sample(rig.samples(SWEEP.duration))
            fit = refine(Study(rig, loop, known, v_cmd, seed=seed))
            known, seconds = fit.estimates, seconds + fit.runs * SWEEP.duration
        found |= {f"{part.name}.{name}": one.value for name, one in known.items()}
        seconds += rig.seconds
    return found, seconds


class _Trial:
    """The cost of a candidate: the geometric mean of its errors over those without compensation.

    The errors are against the command. Against the response of the entrant's own loop a slack loop
    seems to follow well, because that response lags as well.
    """

    fatal = (cosim.CosimError,)

    def __init__(
        self,
        one: Entrant,
        loop: VelocityLoop,
        courses: Courses,
        response: ChainResponse,
        coarse: Coarse,
        plain: Mapping[str, float],  # errors without compensation by command
        sheet: Datasheet,
        *,
        shown: Mapping[str, float],  # parameters that experiments showed
    ) -> None:
        self.one, self.loop, self.courses, self.response = one, loop, courses, response
        self.coarse, self.plain, self.sheet, self.shown = coarse, plain, sheet, shown
        problem = one.problem(coarse)
        self.names = problem.names if problem else []
        self.costs: list[float] = []

    def __call__(self, values: Array) -> float:
        """Return the cost of a candidate (k,); raise CandidateFailed where loop or run fails."""
        self.costs.append(float("inf"))
        try:
            tuned = self.tuned_by(dict(zip(self.names, values.tolist(), strict=True)))
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

    def tuned_by(self, genes: Mapping[str, float]) -> TunedEntrant:
        """Return the entrant with values of its genes."""
        tuned = self.one.tuned(genes, self.loop, self.coarse, self.sheet)
        return replace(tuned, parameters={**tuned.parameters, **self.shown})

    def error(self, tuned: TunedEntrant, robust: Robustness) -> float:
        """Return the cost of runs; raise CandidateFailed when one fails."""
        noise = robust.noise * self.sheet.encoder_step / np.sqrt(12.0)
        try:
            found = self.courses.errors(tuned, noise)
        except (cosim.SimulationError, ControlError) as error:
            raise ga.CandidateFailed(str(error)) from error
        ratios = [error / self.plain[name] for name, error in found.items()]
        return float(np.exp(np.mean(np.log(ratios))))
