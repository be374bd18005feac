"""Whether a compensator helps, and at which share of its force it never makes the loop worse.

Each way to compensate is a chain of compensators. It is tried on every drive of a family, on every
command, and compared with the loop without compensation. Where friction has halved, exact
feedforward leaves an error like that without it, or a larger one; a share of 0.85 to 0.9 of its
force then leaves less, and hardly more on the fitted drive.

Where a drive sticks and slips, errors of runs that hardly differ scatter by some per cent. A ratio
near the limit is therefore the mean of several such runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial
from pathlib import Path

import numpy as np

from stickslip import cosim
from stickslip.catalog.parameters import friction_law
from stickslip.evaluation.guards.family import MOVES, Command, Drive
from stickslip.evaluation.guards.trial import axis_values
from stickslip.identification.criteria.runs import Runs
from stickslip.models import Law
from stickslip.servo.datasheet import Datasheet
from stickslip.servo.systems import Compensator, Feed, build_fmus, build_loop
from stickslip.servo.velocity_loop import VelocityLoop

WORSE = 1.005
"""Largest ratio of the error with the compensator to that without it, on a drive of the family; the
true drive differs from all of them, and may then be worse by one or two per cent."""
SHARES = (1.0, 0.95, 0.9, 0.85, 0.8, 0.75, 0.7, 0.65, 0.6, 0.55, 0.5, 0.4, 0.3, 0.2, 0.1)
LEVELS = tuple(np.linspace(0.99, 1.01, 8).tolist())
"""Levels of friction at which a run is repeated where it sticks and slips."""
CLOSE = (0.9, 1.25)
"""Ratios between which a run is repeated: a single one may pass or fail by chance."""
FEEDFORWARD = "compensator"
"""Model whose force a share reduces."""


@dataclass(frozen=True)
class Variant:
    """A way to compensate.

    Attributes
    ----------
    name : for people, such as "feedforward"
    chain : compensators in the order in which their forces are added; empty for none
    """

    name: str
    chain: tuple[Compensator, ...] = ()

    @property
    def has_feedforward(self) -> bool:
        """Whether a share of its force can be taken."""
        return any(one.model == FEEDFORWARD for one in self.chain)

    def share(self, law: Law, share: float) -> Variant:
        """Return the same with a share of the feedforward's force."""
        chain = (
            replace(one, values=law.share(one.values, share)) if one.model == FEEDFORWARD else one
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
        found: Mapping[str, float] = {}
        for one in self.chain:
            found = one.values if one.model == FEEDFORWARD else found
        return dict(found)


NONE = Variant("none")


def feedforward(values: Mapping[str, float], name: str = "feedforward") -> Variant:
    """Return feedforward of friction by its parameters."""
    return Variant(name, (Compensator(FEEDFORWARD, FEEDFORWARD, values),))


@dataclass(frozen=True)
class Tried:
    """RMS of v - v_cmd [m/s] on one simulated drive, without and with compensation.

    Attributes
    ----------
    speed : largest of the command [m/s]
    drive : how its friction differs from the fitted one
    command : its name
    """

    speed: float
    drive: str
    without: float
    compensated: float
    command: str = ""

    @property
    def ratio(self) -> float:
        """How many times larger the error is by the compensator; infinite if not finite."""
        if not math.isfinite(self.compensated) or not self.without > 0.0:
            return math.inf
        return self.compensated / self.without

    @property
    def is_worse(self) -> bool:
        """Whether the error grows by more than allowed."""
        return not self.ratio <= WORSE


@dataclass(frozen=True)
class Benefit:
    """What one variant does to the tracking error.

    Attributes
    ----------
    share : of the feedforward's force; the largest of ``SHARES`` that is acceptable, or 1
    rows : at that share, one for each drive and command
    full : the same at the whole force
    unit : of a thousandth of a speed, for people
    variant : at its whole force
    """

    share: float
    rows: tuple[Tried, ...]
    full: tuple[Tried, ...]
    unit: str = "mm/s"
    variant: Variant = NONE

    @property
    def acceptable(self) -> bool:
        """Whether the error is nowhere worse with the compensator than without it."""
        return not any(row.is_worse for row in self.rows)

    @property
    def mean_ratio(self) -> float:
        """Geometric mean of the ratios of the errors."""
        return float(np.exp(np.mean(np.log([max(row.ratio, 1e-9) for row in self.rows]))))

    @property
    def reason(self) -> str:
        """Where the whole force makes the error grow most."""
        worst = max(self.full, key=lambda row: row.ratio)
        where = f"at {1e3 * worst.speed:.3g} {self.unit}"
        if worst.command in MOVES:
            where = f"in {worst.command} of up to {1e3 * worst.speed:.3g} {self.unit}"
        return (
            f"with the whole force the simulated tracking error {where}"
            f" on a drive with {worst.drive} is {1e3 * worst.compensated:.3g}"
            f" {self.unit}, {worst.ratio:.3g} times that without the compensator"
        )

    @property
    def refusal(self) -> str:
        """Why a compensator that is not acceptable is refused, and what to do."""
        return (
            f"{self.reason}; expected at most {WORSE:g} times, and no share of the force down to"
            f" {SHARES[-1]:g} keeps that; raise K_p, learn from a log that shows more, or"
            " compensate faster commands only"
        )


def best_of(benefits: Sequence[Benefit]) -> Benefit:
    """Return the acceptable one with the smallest mean ratio; the first where none is."""
    acceptable = [benefit for benefit in benefits if benefit.acceptable]
    return min(acceptable, key=lambda one: one.mean_ratio, default=benefits[0])


@dataclass(frozen=True)
class Bench:
    """The loop in which variants are tried, on drives of any law.

    Attributes
    ----------
    folder : empty; FMUs are built into it
    law : of the feedforward
    drives, commands : every drive is tried on every command
    workers : number of runs in parallel
    """

    folder: Path
    law: Law
    loop: VelocityLoop
    drives: Sequence[Drive]
    commands: Sequence[Command]
    feed: Feed = "nominal"
    datasheet: Datasheet = field(default_factory=Datasheet)
    rotary: bool = False
    workers: int = 1

    def __post_init__(self) -> None:
        for name in self.laws:
            build_fmus(self.folder_of(name), {"law": name}, self.law.name)

    @property
    def laws(self) -> tuple[str, ...]:
        """Names of the laws of the drives, that of the feedforward first."""
        return tuple(dict.fromkeys([self.law.name, *(drive.law for drive in self.drives)]))

    def folder_of(self, law: str) -> Path:
        """Return the folder of the FMUs with drives of a law."""
        return self.folder / law

    @cached_property
    def _without(self) -> list[float]:
        """RMS of v - v_cmd [m/s] without compensation, of each drive and command."""
        with _Runs(self, NONE) as runs:
            return runs.each(lambda cell: runs.error(*cell, NONE), self._cells())

    def benefits(
        self, variants: Iterable[Variant], shares: Sequence[float] = SHARES
    ) -> tuple[Benefit, ...]:
        """Try each variant, with the largest acceptable one of the shares of its feedforward."""
        return tuple(self._benefit(variant, shares) for variant in variants)

    def is_worse(self, variant: Variant, row: Tried) -> bool:
        """Tell whether a variant is worse than none where another one's row was tried."""
        cell = next(
            cell
            for cell in self._cells()
            if (cell[0].name, cell[1].name) == (row.drive, row.command)
        )
        with _Runs(self, variant) as runs, _Runs(self, NONE) as none:
            row = replace(row, compensated=runs.error(*cell, variant))
            means = partial(none.mean, *cell, NONE), partial(runs.mean, *cell, variant)
            return _repeated(row, *means).is_worse

    def _cells(self) -> Iterator[tuple[Drive, Command]]:
        for drive in self.drives:
            for command in self.commands:
                yield drive, command

    def _benefit(self, variant: Variant, shares: Sequence[float]) -> Benefit:
        unit = "mrad/s" if self.rotary else "mm/s"
        cells = list(zip(self._cells(), self._without, strict=True))
        with _Runs(self, variant) as runs, _Runs(self, NONE) as none:

            def tried(k: int, share: float) -> Tried:
                (drive, command), error = cells[k]
                compensated = runs.error(drive, command, variant.share(self.law, share))
                return Tried(command.speed, drive.name, error, compensated, command.name)

            full = tuple(runs.each(partial(tried, share=1.0), range(len(cells))))

            @cache
            def without(k: int) -> float:
                return none.mean(*cells[k][0], NONE)

            def checked(k: int, share: float) -> Tried:
                row = full[k] if share == 1.0 else tried(k, share)
                shared = variant.share(self.law, share)
                means = partial(without, k), partial(runs.mean, *cells[k][0], shared)
                return _repeated(row, *means)

            # Where the whole force harms most, a share fails first.
            order = sorted(range(len(cells)), key=lambda k: -full[k].ratio)
            for share in shares if variant.has_feedforward else shares[:1]:
                rows: dict[int, Tried] = {}
                for begin in range(0, len(order), self.workers):
                    some = order[begin : begin + self.workers]
                    rows |= zip(some, runs.each(partial(checked, share=share), some), strict=True)
                    if any(rows[k].is_worse for k in some):
                        break
                else:
                    found = tuple(rows[k] for k in range(len(cells)))
                    return Benefit(share, found, full, unit, variant)
        return Benefit(1.0, full, full, unit, variant)


def _repeated(row: Tried, without: Callable[[], float], compensated: Callable[[], float]) -> Tried:
    """Return a row; if its ratio is close to the limit, with the means of several runs."""
    if not CLOSE[0] < row.ratio < CLOSE[1]:
        return row
    return replace(row, without=without(), compensated=compensated())


class _Runs(ExitStack):
    """Loops with one variant: prepared simulations for each law of the drives."""

    def __init__(self, bench: Bench, variant: Variant) -> None:
        super().__init__()
        loop = bench.loop
        self.T_s, self.axis = loop.T_s, axis_values(loop, bench.datasheet)
        self.n = max(len(command.v_cmd) for command in bench.commands)
        self.commands = {
            command.name: loop.commands(
                np.pad(command.v_cmd, (0, self.n - len(command.v_cmd)), mode="edge")
            )
            for command in bench.commands
        }
        self.simulations = {
            name: self.enter_context(
                Runs(
                    cosim.Specification(
                        build_loop(bench.folder_of(name), loop, variant.chain, bench.feed),
                        step=loop.T_s,
                        stop=(self.n - 1) * loop.T_s,
                        record=("drive.v",),
                    ),
                    bench.workers,
                )
            )
            for name in bench.laws
        }
        self.each = self.simulations[bench.law.name].each

    def error(self, drive: Drive, command: Command, variant: Variant) -> float:
        """Return the RMS of v - v_cmd [m/s]; infinite when the run fails."""
        values = {
            f"drive.{name}": value for name, value in {**self.axis, **drive.parameters}.items()
        }
        until = (len(command.v_cmd) - 1) * self.T_s
        try:
            result = self.simulations[drive.law].run(
                values | variant.parameters, self.commands[command.name], until=until
            )
        except cosim.SimulationError:
            return math.inf
        v = result["drive.v"][: len(command.v_cmd)]
        return float(np.sqrt(np.mean((v - command.v_cmd) ** 2)))

    def mean(self, drive: Drive, command: Command, variant: Variant) -> float:
        """Return the root mean square of the errors [m/s] at the levels of friction ``LEVELS``."""
        law, squares = friction_law(drive.law), 0.0
        for level in LEVELS:
            one = replace(drive, parameters=law.share(drive.parameters, level))
            squares += self.error(one, command, variant) ** 2
        return math.sqrt(squares / len(LEVELS))
