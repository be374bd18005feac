"""Whether a compensator helps, and at which share of its force it never makes the loop worse.

Each way to compensate is a chain of compensators. It is tried on every drive of a family, on every
command, and compared with the loop without compensation. Where friction has halved, exact
feedforward leaves an error like that without it, or a larger one; a share of 0.85 to 0.9 of its
force then leaves less, and hardly more on the fitted drive.

In a cascade the position counts, too, and errors are against the motion without friction, because
a loop without full velocity feedforward lags by more than friction adds.

Where a drive sticks and slips, errors of runs that hardly differ scatter by some per cent. A ratio
near the limit is therefore the mean of several such runs.
"""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import chain, islice
from pathlib import Path

import numpy as np

from stickslip import cosim, models
from stickslip.catalog.parameters import friction_law
from stickslip.identification.criteria.runs import Runs, require_bounded
from stickslip.models import Law
from stickslip.output import steps
from stickslip.servo.axis import Datasheet
from stickslip.servo.systems import Compensator, Feed, build_fmus, build_loop
from stickslip.servo.velocity_loop import VelocityLoop
from stickslip.thresholds import harm, loop_fit
from stickslip.trial.family import MOVES, Command, Drive, axis_values, in_loop

SHARES = (1.0, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5, 0.4, 0.3, 0.2, 0.1)
LEVELS = tuple(np.linspace(0.99, 1.01, 8).tolist())  # of friction, where a run sticks and slips
FIGURES = ("velocity", "position")  # what errors are of; that of the position counts in a cascade
_LEAST = 1e-9  # ratio that counts as none
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

    def share(self, law: Law, share: float) -> Variant:
        """Return the same with a share of the feedforward's force."""
        chain = (
            replace(one, values=law.share(one.values, share)) if one.name == FEEDFORWARD else one
            for one in self.chain
        )
        return replace(self, chain=tuple(chain))

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
    def feedforward_model(self) -> str:
        """Model of its feedforward, that of any law where it has none."""
        return next((one.model for one in self.chain if one.name == FEEDFORWARD), FEEDFORWARD)


NONE = Variant("none")


def feedforward(
    values: Mapping[str, float], name: str = "feedforward", model: str = FEEDFORWARD
) -> Variant:
    """Return feedforward of friction by its parameters."""
    return Variant(name, (Compensator(FEEDFORWARD, model, values),))


@dataclass(frozen=True)
class TrialError:
    """RMS error [m/s] or [m] on one simulated drive, without and with compensation."""

    speed: float  # largest of the command [m/s]
    drive: str  # how its friction differs from the fitted one
    without: float
    compensated: float
    command: str = ""  # its name
    figure: str = "velocity"  # of ``FIGURES``

    @property
    def ratio(self) -> float:
        """How many times larger the error is by the compensator; infinite if not finite."""
        if not math.isfinite(self.compensated) or not self.without > 0.0:
            return math.inf
        return self.compensated / self.without

    @property
    def is_worse(self) -> bool:
        """Whether the error grows by more than allowed."""
        return not self.ratio <= harm.WORSE


Rows = tuple[TrialError, ...]
Errors = tuple[float, ...]  # root mean squares, one for each figure that counts


@dataclass(frozen=True)
class Benefit:
    """What one variant does to the tracking error."""

    share: float  # of the feedforward's force; the largest of ``SHARES`` that is acceptable, or 1
    rows: tuple[TrialError, ...]  # at that share, one for each drive, command and figure
    full: tuple[TrialError, ...]  # the same at the whole force
    unit: str = "mm/s"  # displayed, of a thousandth of a speed
    variant: Variant = NONE  # at its whole force

    def whole(self) -> Benefit:
        """Return the same with the whole force."""
        return replace(self, share=1.0, rows=self.full)

    @property
    def acceptable(self) -> bool:
        """Whether the error is nowhere worse with the compensator than without it."""
        return not any(row.is_worse for row in self.rows)

    def shown(self, row: TrialError) -> tuple[float, str]:
        """Return the factor from SI to the unit in which a row is shown, and that unit."""
        return (1e3, self.unit) if row.figure == "velocity" else (1e6, f"u{self.unit[1:-2]}")

    def tables(self) -> dict[str, Rows]:
        """Return the rows by figure."""
        figures = dict.fromkeys(row.figure for row in self.rows)
        return {name: tuple(row for row in self.rows if row.figure == name) for name in figures}

    @property
    def mean_ratio(self) -> float:
        """Geometric mean of the ratios of the errors."""
        return geometric_mean(self.rows)

    @property
    def fitted_ratio(self) -> float:
        """The same on the first drive, that with friction as fitted."""
        return geometric_mean([row for row in self.rows if row.drive == self.rows[0].drive])

    @property
    def worst_ratio(self) -> float:
        """Largest ratio of the errors."""
        return max(max(row.ratio, _LEAST) for row in self.rows)

    @property
    def reason(self) -> str:
        """Where the whole force makes the error grow most."""
        worst = max(self.full, key=lambda row: row.ratio)
        where = f"at {1e3 * worst.speed:.3g} {self.unit}"
        if worst.command in MOVES:
            where = f"in {worst.command} of up to {1e3 * worst.speed:.3g} {self.unit}"
        if not math.isfinite(worst.ratio):
            return (
                f"the simulated loop {where} on a drive with {worst.drive} runs away"
                f" {'with the whole force' if math.isfinite(worst.without) else 'without it, too'}:"
                f" its velocity exceeds {loop_fit.RUNS_AWAY:g} times the largest commanded one"
            )
        error = "position" if worst.figure == "position" else "tracking"
        factor, unit = self.shown(worst)
        return (
            f"with the whole force the simulated {error} error {where}"
            f" on a drive with {worst.drive} is {factor * worst.compensated:.3g}"
            f" {unit}, {worst.ratio:.3g} times that without the compensator"
        )

    @property
    def refusal(self) -> str:
        """Why a compensator that is not acceptable is refused, and what to do."""
        return (
            f"{self.reason}; expected at most {harm.WORSE:g} times, and no share of the force"
            f" down to {SHARES[-1]:g} keeps that; raise K_p, learn from a log that shows more, or"
            " compensate faster commands only"
        )


def geometric_mean(rows: Sequence[TrialError]) -> float:
    """Return the geometric mean of the ratios of the errors."""
    return float(np.exp(np.mean(np.log([max(row.ratio, _LEAST) for row in rows]))))


def best_of(benefits: Sequence[Benefit]) -> Benefit:
    """Return the acceptable one with the smallest mean ratio; the first where none is."""
    acceptable = [benefit for benefit in benefits if benefit.acceptable]
    return min(acceptable, key=lambda one: one.mean_ratio, default=benefits[0])


@dataclass(frozen=True)
class Bench:
    """The loop in which variants are tried, on drives of any law."""

    folder: Path  # empty; FMUs are built into it
    law: Law  # of the feedforward
    loop: VelocityLoop
    # every drive is tried on every command
    drives: Sequence[Drive]
    commands: Sequence[Command]
    feed: Feed = "nominal"
    datasheet: Datasheet = field(default_factory=Datasheet)
    workers: int = 1  # number of runs in parallel

    def __post_init__(self) -> None:
        own, *others = self.laws
        build_fmus(self.folder_of(own), {"law": own}, own)
        for name in others:  # with the same compensators
            shutil.copytree(self.folder_of(own), self.folder_of(name))
            models.build_fmu("drive", self.folder_of(name), law=name)

    @property
    def laws(self) -> tuple[str, ...]:
        """Names of the laws of the drives, that of the feedforward first."""
        return tuple(dict.fromkeys([self.law.name, *(drive.law for drive in self.drives)]))

    def folder_of(self, law: str) -> Path:
        """Return the folder of the FMUs with drives of a law."""
        return self.folder / law

    @cached_property
    def _without(self) -> list[Errors]:
        """Errors without compensation, of each drive and command."""
        runs = self._runs(NONE)
        return runs.each(lambda cell: runs.errors(*cell, NONE), self._cells())

    @cached_property
    def _mean_without(self) -> dict[tuple[str, str], Errors]:
        """The same where it was needed over several levels of friction, by drive and command."""
        return {}

    @cached_property
    def _prepared(self) -> dict[object, _Runs]:
        """Loops by the models and parameters of their compensators."""
        return {}

    def _runs(self, variant: Variant, laws: Iterable[str] | None = None) -> _Runs:
        """Return the loops of a variant, prepared for drives of some laws, by default of all."""
        key = tuple((one.name, one.model, one.file, *sorted(one.values)) for one in variant.chain)
        runs = self._prepared.get(key)
        if runs is None:
            runs = self._prepared[key] = _Runs(self, variant)
        for law in self.laws if laws is None else laws:
            runs.prepare(law)
        return runs

    def close(self) -> None:
        """Free the FMUs."""
        for runs in self._prepared.values():
            runs.close()
        self._prepared.clear()

    def benefits(
        self, variants: Iterable[Variant], shares: Sequence[float] = SHARES
    ) -> tuple[Benefit, ...]:
        """Try each variant, with the largest acceptable one of the shares of its feedforward."""
        return tuple(self._benefit(variant, shares) for variant in variants)

    def quick_ratio(self, variant: Variant, drives: int) -> float:
        """Return the geometric mean of the ratios of single runs on the first drives."""
        some = zip(self._cells(), self._without, strict=True)
        cells = list(islice(some, drives * len(self.commands)))
        runs = self._runs(variant, dict.fromkeys(drive.law for (drive, _), _ in cells))
        rows = runs.each(lambda one: _rows(*one[0], one[1], runs.errors(*one[0], variant)), cells)
        return geometric_mean(tuple(chain.from_iterable(rows)))

    def is_worse(self, variant: Variant, row: TrialError) -> bool:
        """Tell whether a variant is worse than none where another one's row was tried."""
        cell = next(
            cell
            for cell in self._cells()
            if (cell[0].name, cell[1].name) == (row.drive, row.command)
        )
        runs = self._runs(variant, [cell[0].law])
        without = self._without[list(self._cells()).index(cell)]
        rows = _rows(*cell, without, runs.errors(*cell, variant))
        means = partial(self._without_means, *cell), partial(runs.means, *cell, variant)
        return any(one.is_worse for one in _repeated(rows, *means))

    def _without_means(self, drive: Drive, command: Command) -> Errors:
        key = drive.name, command.name
        if key not in self._mean_without:
            self._mean_without[key] = self._runs(NONE, [drive.law]).means(drive, command, NONE)
        return self._mean_without[key]

    def _cells(self) -> Iterator[tuple[Drive, Command]]:
        for drive in self.drives:
            for command in self.commands:
                yield drive, command

    def _benefit(self, variant: Variant, shares: Sequence[float]) -> Benefit:
        unit = self.loop.axis.unit("mm/s")
        cells = list(zip(self._cells(), self._without, strict=True))
        runs = self._runs(variant)

        def tried(k: int, share: float) -> Rows:
            cell, errors = cells[k]
            return _rows(*cell, errors, runs.errors(*cell, variant.share(self.law, share)))

        whole, batch = list[Rows](), 4 * self.workers
        for begin in steps(range(0, len(cells), batch)):
            ahead = range(len(cells))[begin : begin + batch]
            whole += runs.each(partial(tried, share=1.0), ahead)
        full = tuple(chain.from_iterable(whole))

        def checked(k: int, share: float) -> Rows:
            (cell, _), rows = cells[k], whole[k] if share == 1.0 else tried(k, share)
            shared = variant.share(self.law, share)
            means = partial(self._without_means, *cell), partial(runs.means, *cell, shared)
            return _repeated(rows, *means)

        # Where the whole force harms most, a share fails first.
        order = sorted(range(len(cells)), key=lambda k: -max(one.ratio for one in whole[k]))
        for share in shares if variant.has_feedforward else shares[:1]:
            rows: dict[int, Rows] = {}
            for begin in steps(range(0, len(order), self.workers)):
                some = order[begin : begin + self.workers]
                rows |= zip(some, runs.each(partial(checked, share=share), some), strict=True)
                if any(one.is_worse for k in some for one in rows[k]):
                    break
            else:
                found = chain.from_iterable(rows[k] for k in range(len(cells)))
                return Benefit(share, tuple(found), full, unit, variant=variant)
        return Benefit(1.0, full, full, unit, variant=variant)


def _rows(drive: Drive, command: Command, without: Errors, compensated: Errors) -> Rows:
    """Return the rows of a cell, one for each figure."""
    return tuple(
        TrialError(command.speed, drive.name, plain, own, command=command.name, figure=figure)
        for figure, plain, own in zip(FIGURES, without, compensated, strict=False)
    )


def _repeated(rows: Rows, without: Callable[[], Errors], compensated: Callable[[], Errors]) -> Rows:
    """Return the rows of a cell; if a ratio is close to the limit, with means of several runs."""
    if not any(harm.REPEATED_ABOVE < row.ratio < harm.REPEATED_BELOW for row in rows):
        return rows
    means = zip(rows, without(), compensated(), strict=True)
    return tuple(replace(row, without=one, compensated=two) for row, one, two in means)


class _Runs(ExitStack):
    """Loops with one variant: prepared simulations for each law of the drives."""

    def __init__(self, bench: Bench, variant: Variant) -> None:
        super().__init__()
        loop = bench.loop
        noise = bench.datasheet.encoder_noise
        optics = {"noise": noise > 0.0, "noise_x": noise, "noise_F": 0.0}
        self.T_s, self.axis = loop.T_s, {**axis_values(loop, bench.datasheet), **optics}
        self.n = max(len(command.v_cmd) for command in bench.commands)
        self.commands = {
            command.name: loop.commands(
                np.pad(command.v_cmd, (0, self.n - len(command.v_cmd)), mode="edge")
            )
            for command in bench.commands
        }
        self.targets = {
            command.name: dict(
                zip(("drive.v", "drive.x"), loop.response(command.v_cmd), strict=True)
            )
            if loop.K_x
            else {"drive.v": command.v_cmd}
            for command in bench.commands
        }
        self.bench, self.chain = bench, variant.chain
        self.speed = max(command.speed for command in bench.commands)
        self.simulations: dict[str, Runs] = {}
        self.prepare(bench.law.name)
        self.each = self.simulations[bench.law.name].each

    def prepare(self, law: str) -> None:
        """Prepare the loop with drives of a law, once."""
        if law in self.simulations:
            return
        bench = self.bench
        specification = cosim.Specification(
            build_loop(bench.folder_of(law), bench.loop, self.chain, bench.feed),
            step=self.T_s,
            stop=(self.n - 1) * self.T_s,
            record=("drive.v", "drive.x"),
        )
        self.simulations[law] = self.enter_context(Runs(specification, bench.workers))

    def errors(self, drive: Drive, command: Command, variant: Variant) -> Errors:
        """Return the RMS of v - v_cmd [m/s], or those of a cascade against its targets.

        They are infinite when the run fails or the loop runs away.
        """
        targets = self.targets[command.name]
        values = in_loop({**self.axis, **drive.parameters})
        until = (len(command.v_cmd) - 1) * self.T_s
        try:
            result = self.simulations[drive.law].run(
                values | variant.parameters, self.commands[command.name], until=until
            )
            require_bounded(result["drive.v"], self.speed)
        except cosim.SimulationError:
            return (math.inf,) * len(targets)
        return tuple(
            float(np.sqrt(np.mean((result[name][: len(target)] - target) ** 2)))
            for name, target in targets.items()
        )

    def means(self, drive: Drive, command: Command, variant: Variant) -> Errors:
        """Return the root mean square of the errors at the levels ``LEVELS``, with other noise."""
        law, found = friction_law(drive.law), []
        for seed, level in enumerate(LEVELS):
            parameters = {**law.share(drive.parameters, level), "seed": seed}
            found.append(self.errors(replace(drive, parameters=parameters), command, variant))
        return tuple(math.sqrt(sum(x * x for x in of) / len(of)) for of in zip(*found, strict=True))
