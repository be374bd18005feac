"""Whether a compensator helps, and at which share of its force it does best.

Each way to compensate is a chain of compensators. It is tried on every drive of a family, in every
motion, and compared with the loop without compensation. The drives have several levels of friction:
that of the log, and what it may become. A compensator is acceptable where it is in no motion worse
than none on half of the drives of a level, hardly worse on three quarters, and on none of them by
more than single runs scatter, or than all gain in the mean.

Errors are against the motion of the loop without friction: what is left of them is what a
compensator can still do. In a cascade the position counts, too.
"""

import math
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, groupby, product
from pathlib import Path

import numpy as np

from stickslip import cosim, models
from stickslip.catalog.parameters import friction_law
from stickslip.cosim import Trapezoid
from stickslip.fmi.process import temporary_folder
from stickslip.identification.criteria.runs import Outcome, Runs, bounded
from stickslip.models import Law
from stickslip.output import steps
from stickslip.servo.axis import Datasheet
from stickslip.servo.lanes import Run
from stickslip.servo.measurement import Array
from stickslip.servo.systems import CONTROL, Compensator, Feed, build_loop
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.thresholds import harm, loop_fit
from stickslip.trial.family import (
    CREEP,
    MOVES,
    SLOW_MOVE,
    SWEEP,
    Command,
    Drive,
    axis_values,
    commands,
    in_loop,
    onsets,
    speed_text,
    sweep,
)

SHARES = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
FIGURES = ("velocity", "position")  # what errors are of; that of the position counts in a cascade
TOGETHER = 8  # commands of a sweep that are run at once, though one of them may end it
_LEAST = 1e-9  # ratio that counts as none
RISING = "dahl"  # law of a feedforward that rises along the way, of any bench
FEEDFORWARD = "compensator"  # component that a share reduces, and the model of any law


@dataclass(frozen=True)
class Variant:
    """A way to compensate."""

    name: str  # display name, such as "feedforward"
    chain: tuple[Compensator, ...] = ()  # in the order of their forces; empty for none

    @property
    def has_feedforward(self) -> bool:
        """Whether a share of its force can be taken."""
        return any(one.name == FEEDFORWARD for one in self.chain)

    def share(self, law: Law, share: float) -> "Variant":
        """Return the same with a share of the feedforward's force, of that law or of its own."""

        def shared(one: Compensator) -> Compensator:
            own = friction_law(one.law) if one.law else law
            return replace(one, values=own.share(one.values, share))

        chain = (shared(one) if one.name == FEEDFORWARD else one for one in self.chain)
        return replace(self, chain=tuple(chain))

    def changed(self, part: Compensator, name: str, value: float) -> "Variant":
        """Return the same with another value of one of its parts."""
        other = replace(part, values={**part.values, name: value})
        return replace(self, chain=tuple(other if one is part else one for one in self.chain))

    @property
    def parameters(self) -> dict[str, float]:
        """Start values of the loop's FMUs."""
        return {
            f"{one.name}.{name}": value for one in self.chain for name, value in one.values.items()
        }

    @property
    def feedforward(self) -> dict[str, float]:
        """Parameters of its feedforward by name; empty without one."""
        return {
            k: v for one in self.chain if one.name == FEEDFORWARD for k, v in one.values.items()
        }

    @property
    def feedforward_kind(self) -> tuple[str, str]:
        """Model and law of its feedforward; that of any law where it has none."""
        kinds = ((one.model, one.law) for one in self.chain if one.name == FEEDFORWARD)
        return next(kinds, (FEEDFORWARD, ""))


NONE = Variant("none")


def feed_of(chain: Sequence[Compensator]) -> Feed:
    """Return what gives the velocity: the command, where no feedforward hands on another."""
    return "nominal" if any(one.name == FEEDFORWARD for one in chain) else "command"


def feedforward(
    values: Mapping[str, float], name: str = "feedforward", model: str = FEEDFORWARD
) -> Variant:
    """Return feedforward of friction by its parameters."""
    return Variant(name, (Compensator(FEEDFORWARD, model, values),))


@dataclass(frozen=True)
class TrialError:
    """RMS error [m/s] or [m] on a simulated drive, against its loop without friction."""

    speed: float  # largest of the command [m/s]
    drive: str  # how its friction differs from the fitted one
    without: float
    compensated: float
    command: str = ""  # its name
    figure: str = "velocity"  # of ``FIGURES``
    level: float = 1.0  # of friction, over that in the log
    law: str = ""  # of the drive

    @property
    def ratio(self) -> float:
        """How many times larger the error is by the compensator; infinite if not finite."""
        if not math.isfinite(self.compensated) or not self.without > 0.0:
            return math.inf
        return self.compensated / self.without


Rows = tuple[TrialError, ...]
Cell = tuple[Drive, Command]
Errors = tuple[float, ...]  # root mean squares, one for each figure that counts


@dataclass(frozen=True)
class MotionErrors:
    """Errors in one motion, on all drives with one level of friction."""

    rows: Rows

    @property
    def level(self) -> float:
        """Level of friction, over that in the log."""
        return self.rows[0].level

    @property
    def median(self) -> TrialError:
        """The row of the median ratio, of two the larger one."""
        return self._at(0.5)

    def _at(self, share: float) -> TrialError:
        """Return the row whose ratio is larger than that share of the others."""
        ordered = sorted(self.rows, key=lambda row: row.ratio)
        return ordered[math.ceil(share * (len(ordered) - 1))]

    @property
    def worst(self) -> TrialError:
        """The row of the largest ratio."""
        return max(self.rows, key=lambda row: row.ratio)

    @property
    def span(self) -> tuple[float, float]:
        """Least and largest ratio."""
        ratios = [row.ratio for row in self.rows]
        return min(ratios), max(ratios)

    @property
    def interval(self) -> tuple[float, float]:
        """Ratios between which that of the true drive is expected."""
        low, high = self.span
        return low / harm.PROMISED, high * harm.PROMISED

    @property
    def is_worse(self) -> bool:
        """Whether the error grows on half of the runs, by more on a quarter, or by much on one."""
        ratios = self.median.ratio, self._at(harm.DRIVES).ratio, self.worst.ratio
        limits = harm.WORSE, harm.MORE, harm.SCATTER
        return not all(ratio <= limit for ratio, limit in zip(ratios, limits, strict=True))


def by_motion(rows: Iterable[TrialError], *, apart: bool = False) -> list[MotionErrors]:
    """Return the rows by level of friction, motion and figure, in their order.

    With ``apart`` commands of the same name and of other speeds are other motions.
    """
    found: dict[tuple[object, ...], list[TrialError]] = {}
    for row in rows:
        key = (row.level, row.command, row.figure, row.speed if apart else 0.0)
        found.setdefault(key, []).append(row)
    return [MotionErrors(tuple(one)) for one in found.values()]


def harmful(swept: Rows, most: float) -> tuple[TrialError, float] | None:
    """Return a run of a sweep that decides against a compensator, and the limit that it exceeds.

    No run may be above ``most``, but in slow small moves, where single drives are chance: the loop
    just breaks away, or just does not. There the median of the drives decides. What is no chance is
    the median on one drive of three motions beside each other, of any kind.
    """
    slow = [row for row in swept if row.command == SLOW_MOVE]
    fast = [row for row in swept if row.command != SLOW_MOVE]
    of_drive: dict[tuple[str, ...], list[TrialError]] = {}
    for row in swept:
        of_drive.setdefault((row.drive, row.command, row.figure), []).append(row)
    ordered = [sorted(rows, key=lambda row: row.speed) for rows in of_drive.values()]
    beside = chain.from_iterable(zip(rows, rows[1:], rows[2:], strict=False) for rows in ordered)
    limits = (
        (fast, most),
        ((one.median for one in by_motion(slow, apart=True)), harm.SLOWLY),
        ((MotionErrors(three).median for three in beside), harm.PERSISTS),
    )
    for rows, limit in limits:
        worst = max(rows, key=lambda row: row.ratio, default=None)
        if worst and worst.ratio > limit:
            return worst, limit
    return None


@dataclass(frozen=True)
class Benefit:
    """What one variant does to the tracking error."""

    share: float  # of the feedforward's force: the best acceptable one of ``SHARES``, or 1
    rows: Rows  # at that share, one for each drive, command and figure
    full: Rows  # the same at the whole force
    unit: str = "mm/s"  # displayed, of a thousandth of a speed
    variant: Variant = NONE  # at its whole force
    beyond: Rows = ()  # on drives that do not decide, at that share
    swept: Rows = ()  # in the sweep of commands, at that share; only of what would be written

    def whole(self) -> "Benefit":
        """Return the same with the whole force."""
        return replace(self, share=1.0, rows=self.full, swept=())

    @cached_property
    def motions(self) -> list[MotionErrors]:
        """The rows by level of friction, motion and figure."""
        return by_motion(self.rows)

    @cached_property
    def acceptable(self) -> bool:
        """Whether the error is in no motion worse, and no drive loses more than all gain."""
        return self.is_safe and is_acceptable(self.rows)

    @property
    def most(self) -> float:
        """Largest ratio that may be: no drive may lose more than all gain in the mean."""
        return 2.0 - self.mean_ratio

    @cached_property
    def harmed(self) -> tuple[TrialError, float] | None:
        """The run of the sweep that decides against it, and the limit; None if none does."""
        return harmful(self.swept, self.most)

    @property
    def is_safe(self) -> bool:
        """Whether it harms nowhere in the sweep."""
        return self.harmed is None

    def shown(self, row: TrialError) -> tuple[float, str]:
        """Return the factor from SI to the unit in which a row is shown, and that unit."""
        if row.figure == "velocity":
            return 1e3, self.unit
        length = self.unit.removesuffix("/s")
        return (1e3, length) if row.compensated >= 1e-3 else (1e6, f"u{length[1:]}")

    @cached_property
    def mean_ratio(self) -> float:
        """Geometric mean of the ratios of the errors."""
        return geometric_mean(self.rows)

    @cached_property
    def fitted_ratio(self) -> float:
        """The same on the first drive, that with friction as fitted."""
        return geometric_mean([row for row in self.rows if row.drive == self.rows[0].drive])

    @cached_property
    def worst_ratio(self) -> float:
        """Largest ratio."""
        return max(row.ratio for row in self.rows)

    @property
    def weighed(self) -> float:
        """Mean ratio times the largest one where that is above 1: of two alike the safer counts."""
        return self.mean_ratio * max(self.worst_ratio, 1.0)

    @property
    def reason(self) -> str:
        """Where the error grows most: in the sweep, or with the whole force."""
        motion = max(by_motion(self.full), key=lambda one: one.worst.ratio)
        row, force = motion.worst, f"with the whole force{self._alone}"
        if self.harmed:
            row, force = self.harmed[0], f"at {self.share:g} of its force"
            motion = MotionErrors((row,))
        speed = speed_text(row.speed, rotary="rad" in self.unit)
        where = f"at {speed}"
        if row.command in (CREEP, *MOVES, *SWEEP):
            where = f"in {row.command} of up to {speed}"
        friction = "friction as learned"
        if row.level != 1.0:
            friction = f"{row.level:g} times the friction"
        if not math.isfinite(row.ratio):
            return (
                f"the simulated loop {where} on drives with {friction} runs away"
                f" {force if math.isfinite(row.without) else 'without it, too'}:"
                f" its velocity exceeds {loop_fit.RUNS_AWAY:g} times the largest commanded one"
            )
        error = "position" if row.figure == "position" else "tracking"
        factor, unit = self.shown(row)
        low, n = motion.span[0], len({one.drive for one in motion.rows})
        spread = f" (the worst of {n} drives; at best {low:.3g} times)" if n > 1 else ""
        return (
            f"{force} the simulated {error} error {where} with {friction} is"
            f" {factor * row.compensated:.3g} {unit}, {row.ratio:.3g} times that without the"
            f" compensator{spread}"
        )

    @property
    def _alone(self) -> str:
        """What is told of the whole force of a feedforward with an observer behind it."""
        both = self.variant.has_feedforward and len(self.variant.chain) > 1
        return " and no observer" if both else ""

    @property
    def why_less(self) -> str:
        """Why it has a share of its force only; empty where it has the whole."""
        if self.share == 1.0:
            return ""
        worst = max(self.full, key=lambda row: row.ratio)
        if worst.ratio <= 1.0:
            return "with which it errs least"
        where = ("at " if worst.command[0].isdigit() else "in ") + worst.command
        friction = "" if worst.level == 1.0 else f" with {worst.level:g} times the friction"
        error = f"the error {where}{friction} may be {worst.ratio:.3g} times as large"
        return f"with all of it{self._alone} {error}"

    @property
    def refusal(self) -> str:
        """Why a compensator that is not acceptable is refused, and what to do."""
        most = self.harmed[1] if self.harmed else harm.WORSE
        return (
            f"{self.reason}; expected at most {most:.3g} times, and no share of the force"
            f" down to {SHARES[-1]:g} keeps that; raise K_p, learn from a log that shows more, or"
            " compensate faster commands only"
        )


def geometric_mean(rows: Sequence[TrialError]) -> float:
    """Return the geometric mean of the ratios of the errors.

    Each motion counts once, however many lengths of its moves and speeds were tried.
    """
    motions = ([max(row.ratio, _LEAST) for row in one.rows] for one in by_motion(rows))
    return float(np.exp(np.mean([np.mean(np.log(ratios)) for ratios in motions])))


def is_acceptable(rows: Rows) -> bool:
    """Tell whether no motion is worse, and no drive loses more than all gain in the mean."""
    lost = max(row.ratio for row in rows) - 1.0
    return not any(one.is_worse for one in by_motion(rows)) and lost <= 1.0 - geometric_mean(rows)


def best_of(benefits: Sequence[Benefit]) -> Benefit:
    """Return the acceptable one with the smallest mean ratio; the first where none is."""
    acceptable = [benefit for benefit in benefits if benefit.acceptable]
    return min(acceptable, key=lambda one: one.mean_ratio, default=benefits[0])


@dataclass(frozen=True)
class Bench:
    """The loop in which variants are tried, on drives of any law."""

    folder: Path  # FMUs are built into it
    law: Law  # of the feedforward
    loop: VelocityLoop
    drives: Sequence[Drive]
    commands: Sequence[Command]
    datasheet: Datasheet = field(default_factory=Datasheet)
    workers: int = 1  # number of runs in parallel
    onsets: Sequence[float] = ()  # displacements from which observers may act [m]
    sweep: Sequence[Command] = ()  # on which all drives are tried with what would be written
    # loops by the models and parameters of their compensators
    _prepared: "dict[object, LoopRuns]" = field(default_factory=dict, init=False)
    # errors by loop, parameters, drive and command; largest ratios by command of the sweep
    _known: dict[object, Errors] = field(default_factory=dict, init=False)
    _worst: dict[Command, float] = field(default_factory=dict, init=False)

    def fmus(self, law: str, chain: Sequence[Compensator]) -> Path:
        """Return the folder of a loop with a drive of a law; its FMUs are built on first use."""
        folder = self.folder / law
        kinds: dict[str, tuple[str, str | None]] = {"drive": ("drive", law)}
        kinds |= {name: (name, None) for name in CONTROL}
        for one in chain:
            own = one.law or self.law.name if one.model == FEEDFORWARD else None
            kinds[one.file or one.model] = one.model, own
        for file, (model, own) in kinds.items():
            if (folder / f"{file}.fmu").exists():
                continue
            alike = next(self.folder.glob(f"*/{file}.fmu"), None) if model != "drive" else None
            if alike is None:
                models.build_fmu(model, folder, law=own, called=file)
            else:
                folder.mkdir(exist_ok=True)
                shutil.copy(alike, folder)
        return folder

    @property
    def longest_move(self) -> float:
        """Length of the longest small move of the sweep [m]."""
        moves = [one.v_cmd for one in self.sweep if one.name == SLOW_MOVE]
        return max(float(np.ptp(np.cumsum(one))) for one in moves) * self.loop.T_s

    @cached_property
    def targets(self) -> dict[Command, dict[str, Array]]:
        """Signals (n,) of the loop without friction, by command and name."""
        figures = ("drive.v", "drive.x") if self.loop.K_x else ("drive.v",)
        return {
            one: dict(zip(figures, self.loop.response(one.v_cmd), strict=False))
            for one in (*self.commands, *self.sweep)
        }

    @property
    def samples(self) -> int:
        """Length of the longest command."""
        return max(len(one.v_cmd) for one in (*self.commands, *self.sweep))

    def inputs(self, loop: VelocityLoop) -> dict[Command, dict[str, Array]]:
        """Return the commands (samples,) of a loop by name of the input."""
        return {
            one: loop.commands(np.pad(one.v_cmd, (0, self.samples - len(one.v_cmd)), mode="edge"))
            for one in (*self.commands, *self.sweep)
        }

    @cached_property
    def own_inputs(self) -> dict[Command, dict[str, Array]]:
        """Those of the bench's loop."""
        return self.inputs(self.loop)

    def _errors(self, variant: Variant, cells: Sequence[Cell]) -> list[Errors]:
        """Return the errors with a variant in each cell."""
        key = tuple((one.name, one.model, one.file, *sorted(one.values)) for one in variant.chain)
        if key not in self._prepared:
            self._prepared[key] = LoopRuns(self, self.loop, variant.chain)
        own = key, tuple(variant.parameters.items())
        left = [cell for cell in cells if (own, cell[0].name, cell[1]) not in self._known]
        (runs,) = self._prepared[key].outcomes([variant.parameters], left)
        for run, (drive, command) in zip(runs, left, strict=True):
            self._known[own, drive.name, command] = errors_of(run, self.targets[command])
        return [self._known[own, drive.name, command] for drive, command in cells]

    def close(self) -> None:
        """Free the FMUs."""
        for runs in self._prepared.values():
            runs.close()
        self._prepared.clear()

    def benefits(
        self, variants: Iterable[Variant], shares: Sequence[float] = SHARES
    ) -> tuple[Benefit, ...]:
        """Try each variant, with the best acceptable one of the shares of its feedforward."""
        return tuple(self._benefit(variant, shares) for variant in variants)

    def quick_ratio(self, variant: Variant, drives: int) -> float:
        """Return the geometric mean of the ratios of single runs on the first drives."""
        first = self.drives[:drives]
        return geometric_mean(self._tried(variant, [one for one in self.cells if one[0] in first]))

    def is_worse(self, variant: Variant, motion: MotionErrors) -> bool:
        """Tell whether a variant is worse than none where another one's errors were found."""
        row = motion.rows[0]
        wanted = [
            (drive, command)
            for drive, command in self.cells
            if (drive.level, command.name) == (row.level, row.command) and drive.decides
        ]
        return any(one.is_worse for one in by_motion(self._tried(variant, wanted)))

    @cached_property
    def cells(self) -> list[Cell]:
        """Each drive with each of its commands."""
        return [
            (drive, command)
            for drive in self.drives
            for command in self.commands
            if not command.drives or drive.name in command.drives
        ]

    def swept(self, variant: Variant, most: float) -> Rows:
        """Try a variant in the sweep, until a command harms, or a ratio is above ``most``.

        It begins where others harmed most. Whether a drive just breaks away without compensation is
        chance, so that the error without it is the largest of that command and of those next to
        it, relative to their speeds.
        """
        found = Rows()
        deciding = [one for one in self.drives if one.decides]
        worst_first = sorted(self.sweep, key=lambda one: -self._worst.get(one, 0.0))
        self._errors(NONE, list(product(deciding, worst_first)))
        for k, command in enumerate(worst_first):
            if not k % TOGETHER:
                self._errors(variant, list(product(deciding, worst_first[k : k + TOGETHER])))
            cells = [(drive, command) for drive in deciding]
            without = [(0.0,)] * len(cells)
            for one in self._beside[command]:
                near = self._errors(NONE, [(drive, one) for drive in deciding])
                relative = [(error * (command.speed / one.speed),) for error, *_ in near]
                without = list(map(max, without, relative))
            found += (own := rows_of(cells, without, self._errors(variant, cells)))
            self._worst[command] = max(row.ratio for row in own)
            if harmful(own, most):
                break
        return found

    @cached_property
    def _beside(self) -> dict[Command, Sequence[Command]]:
        """Each command of the sweep with those of its name that are next to it."""
        found: dict[Command, Sequence[Command]] = {}
        for _, group in groupby(self.sweep, key=lambda one: one.name):
            every = list(group)
            found |= {one: every[max(k - 1, 0) : k + 2] for k, one in enumerate(every)}
        return found

    def _tried(self, variant: Variant, cells: Sequence[Cell]) -> Rows:
        """Return the rows of some cells."""
        return rows_of(cells, self._errors(NONE, cells), self._errors(variant, cells))

    def _benefit(self, variant: Variant, shares: Sequence[float]) -> Benefit:
        unit = self.loop.axis.unit("mm/s")
        deciding = [cell for cell in self.cells if cell[0].decides]
        others = [cell for cell in self.cells if not cell[0].decides]
        full = self._tried(variant, deciding)
        groups: dict[tuple[float, str], list[Cell]] = {}
        for drive, command in deciding:
            groups.setdefault((drive.level, command.name), []).append((drive, command))
        harm_of = {(m.level, m.rows[0].command): m.worst.ratio for m in by_motion(full)}
        worst = max(groups, key=lambda key: harm_of[key])  # a share fails there first
        grouped = list(chain.from_iterable(groups.values()))

        def at(share: float) -> Rows:
            """Return the rows at a share; none where a motion is worse."""
            shared = variant.share(self.law, share)
            if share != 1.0:
                first = self._tried(shared, groups[worst])
                if any(one.is_worse for one in by_motion(first)):
                    return ()
            found = full if share == 1.0 else self._tried(shared, grouped)
            return found if is_acceptable(found) else ()

        best, rows = 1.0, Rows()
        for share in shares if variant.has_feedforward else shares[:1]:
            found = at(share)
            if found and (not rows or geometric_mean(found) < geometric_mean(rows)):
                best, rows = share, found
            elif rows:
                break
        beyond = self._tried(variant.share(self.law, best), others)
        return Benefit(best, rows or full, full, unit, variant=variant, beyond=beyond)


@contextmanager
def bench_of(
    law: Law,  # of the feedforward
    loop: VelocityLoop,
    friction: Mapping[str, float],  # as fitted, parameters of the law by name
    drives: Sequence[Drive],  # see ``family``
    command: Trapezoid,  # at the highest speed; see ``commands``
    datasheet: Datasheet,
    *,
    own: Sequence[Command] = (),  # commands in place of the typical ones, see ``own_motions``
    workers: int = 1,
) -> Iterator[Bench]:
    """Build the loop in which variants are tried."""
    with temporary_folder() as folder:
        step, rotary = datasheet.encoder_step, loop.axis.rotary
        stiffness = loop.K_i + loop.K_p * loop.K_x
        tried = commands(
            command, loop.T_s, friction, step, stiffness=stiffness, rotary=rotary, drives=drives
        )
        rise = 2.0 * math.pi * loop.axis.m / loop.K_p
        swept = sweep(command, loop.T_s, drives, step, stiffness=stiffness, rise=rise)
        bench = Bench(
            folder,
            law,
            loop,
            drives,
            commands=own or tried,
            datasheet=datasheet,
            workers=workers,
            onsets=onsets(law, drives, command, step),
            sweep=() if own else swept,
        )
        with closing(bench):
            yield bench


class LoopRuns(ExitStack):
    """A loop with compensators: its runs on drives of any law, in lanes if possible."""

    def __init__(
        self,
        bench: Bench,
        loop: VelocityLoop,
        chain: Sequence[Compensator],
        record: tuple[str, ...] = ("drive.v", "drive.x"),
    ) -> None:
        super().__init__()
        self._bench, self._loop, self._chain, self._record = bench, loop, chain, record
        sheet = bench.datasheet
        noise = {"noise_x": sheet.encoder_noise, "noise_F": sheet.force_noise}
        self._axis = {**axis_values(loop, sheet), "noise": any(noise.values()), **noise}
        self.inputs = bench.own_inputs if loop is bench.loop else bench.inputs(loop)
        self.speed = max(command.speed for command in bench.commands)
        self._runs: dict[str, Runs] = {}  # by law of the drive

    def outcomes(
        self, loops: Sequence[Mapping[str, float]], cells: Sequence[Cell], *, in_lanes: bool = True
    ) -> list[list[Outcome]]:
        """Return the run with each of some parameters in each cell, or why it failed."""
        found: dict[tuple[int, int], Outcome] = {}
        for law in steps(list(dict.fromkeys(drive.law for drive, _ in cells))):
            own = [k for k, (drive, _) in enumerate(cells) if drive.law == law]
            own.sort(key=lambda k: cells[k][1].name)  # lanes have one command
            places = [(i, k) for k in own for i in range(len(loops))]
            asked = [self._run(loops[i], cells[k]) for i, k in places]
            runs = self._of(law).batch(asked, in_lanes=in_lanes)
            for place, outcome in zip(places, runs, strict=True):
                found[place] = bounded(outcome, "drive.v", self.speed)
        return [[found[i, k] for k in range(len(cells))] for i in range(len(loops))]

    def _of(self, law: str) -> Runs:
        """Return the loop with drives of a law, prepared once."""
        if law not in self._runs:
            bench, T_s = self._bench, self._loop.T_s
            feed = feed_of(self._chain)
            system = build_loop(bench.fmus(law, self._chain), self._loop, self._chain, feed)
            stop = (bench.samples - 1) * T_s
            whole = cosim.Specification(system, step=T_s, stop=stop, record=self._record)
            self._runs[law] = self.enter_context(Runs(whole, bench.workers))
        return self._runs[law]

    def _run(self, values: Mapping[str, float], cell: Cell) -> Run:
        """Return what a loop with these parameters runs in a cell."""
        drive, command = cell
        own: Mapping[str, object] = in_loop({**self._axis, **drive.parameters}) | dict(values)
        return Run(own, self.inputs[command], (len(command.v_cmd) - 1) * self._loop.T_s)


def rows_of(cells: Sequence[Cell], without: Sequence[Errors], found: Sequence[Errors]) -> Rows:
    """Return the rows of some cells by their errors without and with what was tried."""
    return tuple(
        TrialError(
            command.speed,
            drive.name,
            without=plain,
            compensated=own,
            command=command.name,
            figure=figure,
            level=drive.level,
            law=drive.law,
        )
        for (drive, command), before, after in zip(cells, without, found, strict=True)
        for figure, plain, own in zip(FIGURES, before, after, strict=False)
    )


def errors_of(run: Outcome, targets: Mapping[str, Array]) -> Errors:
    """Return the RMS errors of a run against signals (n,) by name; infinite where it has failed."""
    if isinstance(run, cosim.SimulationError):
        return (math.inf,) * len(targets)
    return tuple(
        float(np.sqrt(np.mean((run[name][: len(target)] - target) ** 2)))
        for name, target in targets.items()
    )
