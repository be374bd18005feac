"""How well a tuned entrant does on commands on which it was not tuned."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from stickslip import cosim
from stickslip.compensators.entrants import Entrant, TunedEntrant
from stickslip.identification.criteria.runs import require_bounded
from stickslip.servo.axis import Datasheet
from stickslip.servo.chain_response import ChainResponse
from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop, position_loop
from stickslip.studies.arena.course import Course
from stickslip.studies.arena.drives import STEPS, Changes
from stickslip.studies.arena.metrics import ERROR, RECORDED, Trace, figures
from stickslip.studies.arena.motion_commands import COMMANDS, Command

FEW = 3  # Runs at most on each changed drive
ROBUSTNESS, RESOLUTION = "T", "R"
"""Commands on which a drive is changed: its friction, mass and lag; its encoder and its noise."""
RATIO, WORST = "error ratio", "worst error ratio"
"""Metrics of drives with other friction, mass or lag."""
PER_STEP = "error per encoder step"

Figures = dict[tuple[str, str, str], list[float]]  # (command, metric, unit) -> a value for each run


@dataclass
class ValidationResult:
    """What an entrant did, as plain data."""

    figures: Figures = field(default_factory=dict)  # a value for each start
    reason: str = ""  # why a run failed; its errors are infinite

    def add(self, other: "ValidationResult") -> None:
        """Add the figures of runs with other values."""
        self.reason = self.reason or other.reason
        for key, values in other.figures.items():
            self.figures.setdefault(key, []).extend(values)

    def document(self) -> dict[str, Any]:
        """Return it as JSON takes it."""
        rows = [[*key, values] for key, values in self.figures.items()]
        return {"values": rows, "reason": self.reason}


def validate(
    fmus: Path,
    loop: VelocityLoop,
    one: Entrant,
    tuned: TunedEntrant,
    commands: Sequence[Command],
    starts: int,
    sheet: Datasheet | None = None,
) -> ValidationResult:
    """Run every command from several starts: other noise, other places between encoder steps."""
    found, loop, step = ValidationResult(), one.base(loop), (sheet or Datasheet()).encoder_step
    for position in (False, True):
        chosen = [command for command in commands if command.position == position]
        if not chosen:
            continue
        if position and not one.positions:
            loop = position_loop(loop)
            tuned = replace(tuned, loop=tuned.loop.changed(K_x=loop.K_x))
        sampled = {command.name: command.sample(loop.T_s) for command in chosen}
        with Course(fmus, loop, one, max(map(len, sampled.values())), RECORDED) as course:
            for command in chosen:
                for run in _runs(course, tuned, sampled, command.name, starts, step):
                    if isinstance(run, cosim.SimulationError):
                        found.reason = found.reason or str(run)
                        continue
                    for metric, (value, unit) in figures(command, run, tuned.loop).items():
                        found.figures.setdefault((command.name, metric, unit), []).append(value)
    return found


def _runs(
    course: Course,
    tuned: TunedEntrant,
    sampled: Mapping[str, Array],  # the commands of a course (n,) [m/s] by name
    name: str,
    starts: int,
    step: float,  # of the encoder, between two of which the starts lie evenly [m]
    values: Mapping[str, float] | None = None,  # start values of the drive
) -> Iterator[Trace | cosim.SimulationError]:
    """Yield the run of a command from each start, or why it failed."""
    v_cmd, T_s = sampled[name], course.loop.T_s
    top = max(float(np.max(np.abs(one))) for one in sampled.values())
    for k in range(starts):
        place = step * ((k + 0.5) / starts - 0.5)
        try:
            run = course.run(tuned, v_cmd, {**(values or {}), "seed": k + 1, "x": place})
            require_bounded(run["drive.v"], top)
        except cosim.SimulationError as error:
            yield error
        else:
            yield Trace.of(T_s, v_cmd, run, step)


def validate_changed(
    fmus: Path,
    loop: VelocityLoop,
    one: Entrant,
    tuned: TunedEntrant,
    changes: Changes,  # see ``Drive.changes``
    starts: int,
    sheet: Datasheet,
    factor: float = 1.0,  # on the commands
) -> Figures:
    """Return how much more errors there are on changed drives, as in ``Validated.figures``."""
    loop, step, starts = one.base(loop), sheet.encoder_step, min(starts, FEW)
    commands = {name: COMMANDS[name].scaled(factor) for name in (ROBUSTNESS, RESOLUTION)}
    sampled = {name: command.sample(loop.T_s) for name, command in commands.items()}
    errors: dict[str, list[float]] = {}
    with Course(fmus, loop, one, max(map(len, sampled.values())), RECORDED) as course:
        for label, (name, values) in changes.items():
            errors[label] = [
                figures(commands[name], run, tuned.loop)[ERROR][0]
                for run in _runs(course, tuned, sampled, name, starts, step, values)
                if isinstance(run, Trace)
            ]
    whole = {label: np.array(found) for label, found in errors.items() if len(found) == starts}
    ratios = {
        (changes[label][0], f"{RATIO} {label}", "1"): (found / whole[changes[label][0]]).tolist()
        for label, found in whole.items()
        if label not in (*commands, *STEPS) and changes[label][0] in whole
    }
    worst = [values for (name, _, _), values in ratios.items() if name == ROBUSTNESS]
    if worst and {*changes} == {*whole}:
        ratios[ROBUSTNESS, WORST, "1"] = np.max(worst, axis=0).tolist()
    if {*STEPS} <= {*whole}:
        (fine, low), (coarse, high) = STEPS.items()
        slope = (whole[coarse] - whole[fine]) / ((high - low) * step)
        ratios[RESOLUTION, PER_STEP, "1/s"] = slope.tolist()
    return ratios


def sensitivities(
    fmus: Path, loop: VelocityLoop, one: Entrant, tuned: TunedEntrant, friction: float, mass: float
) -> dict[str, float]:
    """Return peak sensitivities and margins; the true mass [kg] counts in one of them only."""
    with ChainResponse(fmus, loop, one.chain) as response:
        known, true = (tuned.robustness(response, friction, m) for m in (None, mass))
        if not one.positions:
            tuned = replace(tuned, loop=tuned.loop.changed(K_x=position_loop(loop).K_x))
        outer = tuned.robustness(response, friction)
    return {
        "Ms": known.peak,
        "Ms with the true mass": true.peak,
        "Ms of the position loop": outer.peak,
        "gain margin": known.gain_margin,
        "phase margin": known.phase_margin,
    }
