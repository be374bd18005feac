"""What ``stickslip tune LEARNED.json`` does: a search of the loop on the drives of the file."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from statistics import geometric_mean

import pandas as pd

from stickslip import ga
from stickslip.errors import UsageError, with_settings
from stickslip.learned.file import LearnedFile
from stickslip.loops.drive_loop import DriveLoop
from stickslip.loops.family_cost import FamilyCost, cost_of, ratios
from stickslip.models.export.units import motion_unit
from stickslip.output import SILENT, Progress, counted_steps
from stickslip.presentation.table import Column, Table
from stickslip.servo.axis import ControlError
from stickslip.servo.observer import masses_between
from stickslip.thresholds import kept
from stickslip.trial.benefit import FIGURES, Benefit, Rows, Variant
from stickslip.trial.family import Command
from stickslip.trial.hold import Hold
from stickslip.tuning.search import Finalist, Ratios, best_of, choose, search

EVALUATIONS = 300  # candidates in a search
PRESENT, TUNED = "present loop", "tuned loop"


@dataclass(frozen=True)
class TuneSettings:
    """What may change, and how it is searched."""

    # lowest and highest value by ``component.variable``, in SI units
    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    # parameters, or whole components such as ``controller``, that stay as they are
    fixed: tuple[str, ...] = ()
    force_limit: float | None = None  # of the motor [N]; by default that of the file
    evaluations: int = EVALUATIONS
    algorithm: str = "default"  # one of ``ga.ALGORITHMS``
    seed: int = 0
    workers: int = 1
    steps: int = 0  # loops from the present to the best one for which the family is run


@dataclass(frozen=True)
class Step:
    """A loop between the present one and the best one, or the best one."""

    name: str  # display name
    loop: DriveLoop
    Ms: float  # largest peak sensitivity at the masses
    rows: Rows  # errors beside those of the present loop, on the whole family


@dataclass(frozen=True)
class RigMotion:
    """One motion of the drive in one loop."""

    loop: str  # display name
    motion: str  # display name
    errors: tuple[float, ...]  # RMS of velocity [m/s] and, in a cascade, position [m], as measured
    force: float  # largest of the motor [N]
    ripple: float  # RMS of the motor force above the crossover frequency of the present loop [N]
    hold: Hold  # how the position swings in the rest after the motion
    # of the errors to those of the present loop, each with what the steps of the encoder show
    ratios: tuple[float, ...] = ()


@dataclass(frozen=True)
class RigTrial:
    """What the drive showed of the loops that it ran."""

    rig: str  # display name
    motions: tuple[RigMotion, ...]
    budget: int  # of motions
    stopped: str  # why it ended early; empty when all loops ran
    rotary: bool = False

    @property
    def table(self) -> Table:
        """The errors of each motion."""
        columns = (
            Column("loop", "", "loop", "Loop"),
            Column("motion", "", "motion", "Motion"),
            Column("figure", "", "error of", "Error of"),
            Column("unit", "", "unit", "Unit"),
            Column("error", ".4g", "RMS", "RMS"),
            Column("ratio", ".3f", "of the present", "Of the present"),
        )
        rows = [
            {"loop": one.loop, "motion": one.motion, "figure": figure}
            | {"unit": motion_unit(unit, rotary=self.rotary), "error": error, "ratio": ratio}
            for one in self.motions
            for figure, unit, error, ratio in zip(
                FIGURES, ("m/s", "m"), one.errors, one.ratios, strict=False
            )
        ]
        return Table(columns, rows)

    @property
    def sentence(self) -> str:
        """What the drive showed, in a sentence without its end."""
        end = f"; {self.stopped}; the present gains are set again" if self.stopped else ""
        return f"{self.rig} ran {len(self.motions)} of at most {self.budget} motions{end}"


@dataclass(frozen=True)
class TunedDrive:
    """A loop that was tuned, or the present one where nothing better was found."""

    learned: LearnedFile
    settings: TuneSettings
    start: DriveLoop
    best: DriveLoop
    Ms: tuple[float, float]  # largest peak sensitivity at the masses, before and after
    masses: tuple[float, ...]  # at which it holds, relative to the learned one
    rows: Rows  # errors of the best loop beside those of the present one, on the whole family
    names: tuple[str, ...]  # what was searched
    history: pd.DataFrame  # of the search: a row for each candidate
    commands: tuple[Command, ...] = ()  # motions of the trial
    steps: tuple[Step, ...] = ()  # within the limits, the best loop last
    on_rig: RigTrial | None = None  # what a drive showed of the steps

    def __repr__(self) -> str:
        return f"TunedDrive({self.sentence})"

    @property
    def benefit(self) -> Benefit:
        """The errors relative to those of the present loop."""
        unit = self.best.loop.axis.unit("mm/s")
        return Benefit(1.0, self.rows, self.rows, unit, variant=Variant(TUNED))

    @cached_property
    def ratios(self) -> Ratios:
        """The error relative to the present loop, by motion, figure and kind."""
        return ratios(self.rows)

    @property
    def is_better(self) -> bool:
        """Whether another loop than the present one was taken."""
        return self.best is not self.start

    @property
    def sentence(self) -> str:
        """What tuning brings, in a sentence without its end."""
        before, after = self.Ms
        if not self.is_better and self.steps:
            return f"the present loop stays as it is, with Ms = {before:.3g}"
        if not self.is_better:
            return (
                f"none of {len(self.history)} loops with a peak sensitivity of at most"
                f" {kept.SENSITIVITY:g} is better than the present one in the mean and in no motion"
                f" worse; it stays as it is, with Ms = {before:.3g}"
            )
        more = with_settings(
            "; the search was still finding better loops; a larger number of <evaluations> may help"
        )
        mean = geometric_mean(ratio for key, ratio in self.ratios.items() if "RMS" in key)
        worst = max(self.ratios.values())
        return (
            f"the tuned loop leaves {100.0 * mean:.0f} % of the tracking error of the present one,"
            f" RMS over the simulated drives and geometric mean over the motions, and"
            f" {100.0 * worst:.0f} % in the worst motion; the peak sensitivity Ms is {after:.3g}"
            f" instead of {before:.3g}{more if is_unfinished(self.history) else ''}"
        )


def is_unfinished(history: pd.DataFrame) -> bool:
    """Return whether the last third of a search still lowered the cost."""
    least = history["cost"].cummin().to_numpy()
    return bool(least[-1] < kept.ENDED * least[max(2 * len(least) // 3 - 1, 0)])


def tune_drive(
    learned: LearnedFile,
    settings: TuneSettings,
    progress: Progress = SILENT,
    *,
    start: DriveLoop | None = None,  # the present loop, by default that of the file
) -> TunedDrive:
    """Search the loop of a learned drive, and choose among the best on the whole family."""
    start = start or DriveLoop.of(learned)
    problem = start.problem(settings.ranges, settings.fixed)
    sheet = learned.datasheet
    if settings.force_limit:
        sheet = replace(sheet, peak_force=settings.force_limit)
    if not sheet.peak_force > (F_c := learned.friction["F_c"]):
        unit = start.loop.axis.unit("N")
        raise UsageError(
            f"the force limit is {sheet.peak_force:g} {unit} and Coulomb friction {F_c:.3g} {unit}:"
            " the drive cannot move; give the limit of motor or amplifier with <force_limit>"
        )
    progress.stage("building the drives of the family")
    with (
        learned.bench(start.loop, sheet, settings.workers) as bench,
        FamilyCost(bench, start, masses_of(learned), problem.names) as cost,
    ):
        progress.stage(f"tuning {', '.join(problem.names)}")
        limits = ga.Limits(evaluations=settings.evaluations)
        algorithm = ga.optimiser(settings.algorithm, problem, limits, seed=settings.seed)
        search(algorithm, cost, 1, progress.generation)  # the cost has the workers
        progress.stage("running the best loops on all drives")
        loops = {f"{TUNED} {k}": start.with_values(g) for k, g in enumerate(best_of(algorithm))}
        with counted_steps():
            loops = {name: one for name, one in loops.items() if cost.excess(one) <= 1.0}
            loops[PRESENT] = start
            errors = {name: cost.rows(one) for name, one in loops.items()}
        finalists = []
        for name, rows in errors.items():
            found = ratios(rows)
            finalists.append(Finalist(name, loops[name].tunable, found, cost_of(found)))
        chosen = choose(finalists).name
        best, rows = loops[chosen], errors[chosen]
        peaks = cost.sensitivity(start), cost.sensitivity(best)
        steps = tuple(_steps(start, best, settings.steps, cost)) if best is not start else ()
        commands = tuple(bench.commands)
    return TunedDrive(
        learned,
        settings,
        start,
        best,
        Ms=peaks,
        masses=tuple(cost.masses),
        rows=rows,
        names=tuple(problem.names),
        history=algorithm.history,
        commands=commands,
        steps=steps,
    )


def _steps(start: DriveLoop, best: DriveLoop, n: int, cost: FamilyCost) -> Iterator[Step]:
    """Yield n loops in steps, even by the logarithm, to another, without those beyond a limit."""
    before, after = start.tunable, best.tunable
    for k in range(1, n + 1):
        share, values = k / n, dict[str, float]()
        for name, a in before.items():
            b = after[name]
            positive = a > 0.0 and b > 0.0
            values[name] = a * (b / a) ** share if positive else a + share * (b - a)
        try:
            one = best if k == n else start.with_values(values)
        except ControlError:
            continue
        if cost.excess(one) <= 1.0:
            name = TUNED if k == n else f"{100.0 * share:.0f} % of the way"
            yield Step(name, one, cost.sensitivity(one), cost.rows(one))


def masses_of(learned: LearnedFile) -> tuple[float, ...]:
    """Return the masses at which the limit of Ms holds, relative to that of the loop."""
    entry = learned.document["parameters"].get("m") or {}
    loop = learned.loop
    m = loop.axis.m if loop else math.nan
    low, high = (float(entry.get(key) or m) / m for key in ("low", "high"))
    return masses_between(low, high)
