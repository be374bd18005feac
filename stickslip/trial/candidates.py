"""Which compensator does best on the drives that a log supports.

Candidates are the entrants of the arena that need no training on a drive: feedforward without a
law, of the learned law, and of other laws that explain the log; every observer; and an observer
behind a feedforward. They take their values from what was learned, and an observer its gains from
the peak sensitivity, instead of a search on the drive. Each is first run once on a few drives of
the family; the best of each kind are then tried on all of it, each at the best share of its force.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import islice, product

import numpy as np

from stickslip import models
from stickslip.catalog.parameters import friction_law, learnable_laws
from stickslip.compensators.entrants import FEEDFORWARD as ANY_LAW
from stickslip.compensators.entrants import Coarse, Part, entrant, parts
from stickslip.errors import UsageError
from stickslip.models import Law
from stickslip.servo.axis import ControlError
from stickslip.servo.chain_response import ChainResponse, frequencies
from stickslip.servo.observer import FORCE_NOISE, DesignedObserver, design_observer, expected_errors
from stickslip.servo.sensitivity import OpenLoop, Response
from stickslip.servo.systems import Compensator
from stickslip.thresholds import harm, offer
from stickslip.trial import observed
from stickslip.trial.benefit import SHARES as FORCES
from stickslip.trial.benefit import Bench, Benefit, Variant, feedforward, harmful, is_acceptable

AUTO = "auto"  # stands for the compensator that does best, and for the law that a log shows
QUICK = 3  # drives on which candidates are compared first: as fitted, less, more friction
TRIED = 2  # observers, and combinations, that harm nowhere, which are then tried on all drives
MOST_TRIED = 4  # the same with those that harm
SLOWER = (0.1, 1e-2, 1e-3, 1e-4)  # rates of the disturbance, over that of the fastest filter
GRID = 8  # values of a gene that are compared by sensitivity and expected error
LATER = 2.0  # factor from one onset to the next that is tried
RAMPS = (0.1, 0.3, 1.0, 3.0)
"""Velocities at which the ramp of a Coulomb force ends that are compared, over the start value."""
LATE = (0.03, 0.1, 0.3)
"""The same over the speed of the log, for a static feedforward that harms where friction may hold
the drive: slow motions then get less of it."""
SIGNALS = {"encoder": "x_enc", "motor_force": "F_motor"}  # that a controller may lack, by role
_RAMP = "v_t"
_REFERENCE = {"v_ref", "F_added"}


@dataclass(frozen=True)
class Row:
    """A compensator that was tried."""

    name: str  # of its parts, with a plus between them
    simplicity: int  # 0 for no compensator; more for one that is less simple
    sensitivity: float  # largest peak sensitivity for the masses that the log allows
    benefit: Benefit | None = None  # what it does on the family of drives; None for no compensator
    designed: observed.ObserverDesign | None = None  # its observer; None without one

    @property
    def mean(self) -> float:
        """Geometric mean of the ratios of the errors to those without compensation."""
        return self.benefit.mean_ratio if self.benefit else 1.0

    @property
    def weighed(self) -> float:
        """The same times the largest ratio where that is above 1: of two alike the safer counts."""
        return self.benefit.weighed if self.benefit else 1.0

    @property
    def acceptable(self) -> bool:
        """Whether it is nowhere worse than no compensation, by more than it helps in the mean."""
        return self.benefit is None or self.benefit.acceptable

    @property
    def choice(self) -> observed.Choice:
        """Which of feedforward and observer it is."""
        if self.benefit is None:
            return ""
        if not self.benefit.variant.has_feedforward:
            return observed.OBSERVER
        return observed.BOTH if self.designed else observed.FEEDFORWARD


@dataclass(frozen=True)
class CompensatorComparison:
    """Compensators that were tried on the same drives."""

    rows: tuple[Row, ...]  # no compensator first, then by simplicity
    asked: str = AUTO  # name of what was to be tried, or ``AUTO``

    @property
    def chosen(self) -> Row:
        """What is written: what was asked for, or the simplest of the best that are acceptable."""
        if self.asked != AUTO:
            return next((row for row in self.rows if row.name == self.asked), self.rows[-1])
        helps = [row for row in self.rows if row.acceptable and row.mean <= offer.GAIN]
        least = min((row.weighed for row in helps), default=0.0)
        near = [row for row in helps if row.weighed <= (1.0 + offer.SIMPLER) * least]
        return min(near, key=lambda row: (row.simplicity, row.weighed), default=self.rows[0])

    @property
    def simpler(self) -> Row:
        """The best one that is acceptable and simpler than the chosen one."""
        simpler = [
            row
            for row in self.rows
            if row.acceptable and row.simplicity < max(self.chosen.simplicity, 1)
        ]
        return min(simpler, key=lambda row: row.mean)

    @property
    def sentence(self) -> str:
        """What the chosen one leaves of the error, and the next simpler one."""
        one, other = self.chosen, self.simpler
        if self.asked not in (AUTO, one.name):
            return (
                f"there is no {self.asked}: the loop is not robust with such an observer, or the"
                " observer does not reduce the expected error"
            )
        if not one.acceptable:
            return f"{one.name} is worse than no compensator in a motion"
        if one.benefit is None:
            return (
                f"no compensator that is in no motion worse than none leaves less than"
                f" {offer.GAIN:g} of the error"
            )
        worst = other.benefit.worst_ratio if other.benefit else 1.0
        more = f", but up to {worst:.3g} times as much on a drive" if other.mean < one.mean else ""
        return (
            f"{one.name} leaves {one.mean:.3g} of the error without compensation, the next simpler,"
            f" {other.name}, leaves {other.mean:.3g}{more}"
        )

    def whole(self) -> "CompensatorComparison":
        """Return the same with the whole force of each feedforward, as it is by itself."""
        rows = (
            replace(row, benefit=row.benefit.whole()) if row.benefit else row for row in self.rows
        )
        return replace(self, rows=tuple(rows), asked=self.chosen.name)


def offered(law: Law, absent: Sequence[str] = ()) -> dict[str, Part]:
    """Return parts of compensators of a law by name, without those of ``absent`` signals."""
    lacking = {SIGNALS[name] for name in absent}
    found = {
        name: part
        for name, part in parts().items()
        if part.ports is not None
        and not part.learns
        and set(part.friction) <= law.parameters.keys()
        and (part.model != ANY_LAW or (part.law is not None and part.law.name == law.name))
        and not lacking & set(part.ports.inputs.values())
    }
    return dict(sorted(found.items(), key=lambda item: not _is_feedforward(item[1])))


def law_of(compensator: str, law: str, absent: Sequence[str] = ()) -> str:
    """Return the law that is learned for a compensator: with ``auto``, that of its feedforward.

    Raises UsageError when the compensator is unknown, or needs what the controller lacks, or
    training, and when no absent signal has such a name.
    """
    if unknown := {*absent} - SIGNALS.keys():
        raise UsageError(f"absent: expected {' or '.join(SIGNALS)}, got {', '.join(unknown)}")
    words = compensator.split("+")
    if law == AUTO and words[0] in learnable_laws():
        law = words[0]
    if compensator == AUTO:
        return law
    known = offered(friction_law("lugre" if law == AUTO else law), absent)
    chain = entrant(compensator).parts
    for part in chain:
        if part.name in known:
            continue
        why = "learn writes feedforward of the learned law, and observers"
        if part.learns:
            why = "it is trained on the drive; 'stickslip arena --drive learned.json' compares it"
        elif part.model == ANY_LAW and part.law is not None:
            why = f"<law> is {law}"
        elif part.ports and any(SIGNALS[one] in part.ports.inputs.values() for one in absent):
            why = f"it takes a signal that the controller lacks: {', '.join(absent)}"
        there = f"; there are {', '.join(known)}"
        raise UsageError(f"<compensator {compensator}>: '{part.name}': {why}{there}")
    if [_is_feedforward(part) for part in chain] not in ([True], [False], [True, False]):
        raise UsageError(
            f"<compensator {compensator}>: expected a feedforward, an observer, or both in this"
            " order, such as static+ekbf"
        )
    return law


def compare(
    bench: Bench,
    own: Benefit,  # what feedforward of the bench's law does
    friction: Mapping[str, float],  # as fitted, with the Coulomb friction ``F_c`` [N]
    masses: tuple[float, ...],  # relative to that of the axis, at which the limit of Ms holds
    *,
    rivals: Sequence[Variant] = (),  # feedforward of other laws that explain the log
    asked: str = AUTO,  # ``AUTO``, or a name for which ``law_of`` raises nothing
    absent: Sequence[str] = (),  # signals that the controller lacks
) -> CompensatorComparison:
    """Try compensators on the family of drives of a bench."""
    with _Candidates(
        bench, own, friction, masses, offered=offered(bench.law, absent)
    ) as candidates:
        rows = [candidates.none()]
        if asked == AUTO:
            rows += candidates.best(rivals)
        else:
            rows += candidates.named(asked)
        found = CompensatorComparison(tuple(sorted(rows, key=lambda row: row.simplicity)), asked)
        return candidates.swept(found)


def _is_feedforward(part: Part) -> bool:
    return part.ports is not None and set(part.ports.inputs.values()) <= _REFERENCE


class _Candidates(ExitStack):
    """Compensators with values from what was learned."""

    def __init__(
        self,
        bench: Bench,
        own: Benefit,
        friction: Mapping[str, float],
        masses: tuple[float, ...],
        offered: Mapping[str, Part],
    ) -> None:
        super().__init__()
        self.bench, self.own, self.friction, self.masses = bench, own, friction, masses
        self.F_c, self.speed = friction["F_c"], max(one.speed for one in bench.commands)
        self.offered = offered
        self._responses: dict[str, ChainResponse] = {}
        self._designed: dict[int, DesignedObserver] = {}
        self._best: dict[str, int] = {}

    def none(self) -> Row:
        """Return the row of no compensation."""
        return Row("none", 0, self._without)

    def best(self, rivals: Sequence[Variant]) -> list[Row]:
        """Return feedforwards, and the observers and combinations that do best on few drives."""
        rows = [self._feedforward(part) for part in self.offered.values() if _is_feedforward(part)]
        of_rivals = zip(rivals, self.bench.benefits(rivals), strict=True)
        rows += [Row(one.name, 2, self._without, benefit) for one, benefit in of_rivals]
        observers = [part for part in self.offered.values() if not _is_feedforward(part)]
        acceptable = [row for row in rows if row.acceptable]
        alone: list[tuple[Row | None, Part]] = [(None, part) for part in observers]
        for pairs in (alone, list(product(acceptable, observers))):
            quick = [(self._quick(*pair), k) for k, pair in enumerate(pairs)]
            rows += self._tried([pairs[k] for ratio, k in sorted(quick) if np.isfinite(ratio)])
        return rows

    def _tried(self, pairs: Iterable[tuple[Row | None, Part]]) -> list[Row]:
        """Return the rows of the first pairs that harm nowhere, and of those before them.

        An observer is tried behind one feedforward: what it does depends little on which.
        """
        rows: list[Row] = []
        seen: set[str] = set()
        for behind, part in pairs:
            if part.name not in seen:
                rows += self._observer(behind, part)
            seen.add(part.name)
            if sum(one.acceptable for one in rows) == TRIED or len(rows) == MOST_TRIED:
                break
        return rows

    def named(self, name: str) -> list[Row]:
        """Return the rows of one compensator and of its feedforward."""
        chain = [self.offered[word] for word in name.split("+")]
        rows = [self._feedforward(part) for part in chain if _is_feedforward(part)]
        for part in chain:
            if not _is_feedforward(part):
                rows += self._observer(rows[0] if rows else None, part)
        return rows

    def swept(self, found: CompensatorComparison) -> CompensatorComparison:
        """Return the same after what would be written was tried in the sweep, if there is one."""
        if not self.bench.sweep:
            return found
        while (row := found.chosen).benefit and row.acceptable and not row.benefit.swept:
            benefit = self._safe(row.benefit)
            designed = row.designed and replace(row.designed, observer=benefit.variant.chain[-1])
            safe = replace(row, benefit=benefit, designed=designed)
            rows = tuple(safe if one is row else one for one in found.rows)
            found = replace(found, rows=rows)
        return found

    def _safe(self, benefit: Benefit) -> Benefit:
        """Return a compensator that harms nowhere in the sweep: later, or with less force.

        Of each way to change it the first one that harms nowhere takes part, and the best is taken.
        """
        shared = benefit.variant.share(self.bench.law, benefit.share)
        found = replace(benefit, swept=self.bench.swept(shared, benefit.most))
        if found.acceptable:
            return found
        ways = (self._later(benefit), self._softer(benefit), self._weaker(benefit))
        safe = [one for way in ways if (one := self._first_safe(way))]
        return min(safe, key=lambda one: one.weighed, default=found)

    def _first_safe(self, changed: Iterable[Benefit]) -> Benefit | None:
        """Return the first one that helps and harms nowhere in the sweep; None if none does."""
        for one in changed:
            shared = one.variant.share(self.bench.law, one.share)
            swept = self.bench.swept(shared, one.most)
            if harmful(swept, one.most):
                continue
            (other,) = self.bench.benefits([shared], shares=(1.0,))
            full = one.full if one.variant.has_feedforward else other.rows
            found = replace(one, rows=other.rows, beyond=other.beyond, full=full, swept=swept)
            if found.acceptable:  # those that follow take less of the error
                return found if found.mean_ratio <= offer.GAIN else None
        return None

    def _later(self, benefit: Benefit) -> Iterator[Benefit]:
        """Yield the same with an observer that acts from larger displacements [m] on.

        With the last one all moves of the sweep are left alone.
        """
        last = benefit.variant.chain[-1]
        onset, longest = last.values.get("onset", 0.0), harm.ONSET * self.bench.longest_move
        while 0.0 < onset < longest:
            onset = min(LATER * onset, longest)
            yield replace(benefit, variant=benefit.variant.changed(last, "onset", onset))

    def _softer(self, benefit: Benefit) -> Iterator[Benefit]:
        """Yield the same with all of a static feedforward, at larger velocities [m/s]."""
        first = benefit.variant.chain[0]
        if benefit.variant.has_feedforward and _RAMP in first.values:
            for ramp in (k * self.speed for k in LATE):
                if ramp > first.values[_RAMP]:
                    variant = benefit.variant.changed(first, _RAMP, ramp)
                    yield replace(benefit, share=1.0, variant=variant)

    def _weaker(self, benefit: Benefit) -> Iterator[Benefit]:
        """Yield the same with smaller shares of the feedforward's force."""
        for share in FORCES if benefit.variant.has_feedforward else ():
            if share < benefit.share:
                yield replace(benefit, share=share)

    def _feedforward(self, part: Part) -> Row:
        if part.model == ANY_LAW:
            return Row(part.name, 2, self._without, self.own)
        start = self._values(part)
        tried: list[Benefit] = []
        for later in ({}, *({_RAMP: k * self.speed} for k in LATE if _RAMP in start)):
            one = Compensator(part.name, part.model, {**start, **later})
            whole = feedforward(one.parameters(self.bench.loop), part.name, part.model)
            tried += self.bench.benefits([whole])
            if is_acceptable(tried[-1].full):
                break
        acceptable = [one for one in tried if one.acceptable]
        best = min(acceptable, key=lambda one: one.weighed, default=tried[-1])
        return Row(part.name, 1, self._without, best)

    def _quick(self, behind: Row | None, part: Part) -> float:
        """Return the mean ratio of an observer on few drives; infinite without one."""
        designed = next(self._from_best(part, alone=behind is None), None)
        if designed is None:
            return np.inf
        before: tuple[Compensator, ...] = ()
        if behind and behind.benefit:
            before = behind.benefit.variant.share(self.bench.law, behind.benefit.share).chain
        return self.bench.quick_ratio(Variant(part.name, (*before, designed.observer)), QUICK)

    def _from_best(self, part: Part, *, alone: bool) -> Iterator[observed.ObserverDesign]:
        """Yield observers from fast to weak, from the one on that alone is best on few drives."""
        designs = self._designs(part, alone=alone)
        with suppress(ControlError):
            yield from islice(designs, self._best_alone(part), None)

    def _best_alone(self, part: Part) -> int:
        """Return the number of the first design, from fast to weak, better than the next one."""
        if part.name not in self._best:
            least, self._best[part.name] = np.inf, 0
            for k, designed in enumerate(self._designs(part, alone=True)):
                ratio = self.bench.quick_ratio(Variant(part.name, (designed.observer,)), QUICK)
                if ratio >= least:
                    break
                least, self._best[part.name] = ratio, k
        return self._best[part.name]

    def _observer(self, behind: Row | None, part: Part) -> list[Row]:
        """Return the row of an observer; none if there is no observer within the limit of Ms."""
        first = behind.benefit if behind and behind.benefit else self.own
        together = behind is not None
        for onset in self._onsets(part) or ({},):
            designs = (
                designed.changed(onset) for designed in self._from_best(part, alone=not together)
            )
            try:
                designed, benefit = observed.strongest(
                    self.bench, first, designs, together=together
                )
            except ControlError:
                return []
            if benefit.acceptable:
                break
        name = f"{behind.name}+{part.name}" if behind else part.name
        if together and first.acceptable:
            benefit = replace(benefit, full=first.full)
        benefit = replace(benefit, variant=replace(benefit.variant, name=name))
        simplicity = 4 if together else 3
        return [Row(name, simplicity, designed.sensitivity, benefit, designed=designed)]

    def _designs(self, part: Part, *, alone: bool) -> Iterator[observed.ObserverDesign]:
        """Yield observers from fast to weak, all within the limit of Ms."""
        values = self._values(part, alone=alone)
        if part.design:
            designed = self._kalman(2 if part.design == "kalman_2" else 1)
            yield from self._within(part, {**values, **designed.observer.parameters()})
            for factor in SLOWER:
                gains = designed.slower(factor).parameters()
                yield from self._within(part, {**values, **gains})
            for share in observed.SHARES:
                yield from self._within(part, {**values, **gains, "share": share})
            return
        gene, *_ = part.ranges
        best = self._searched(part, values)
        slower = [value for value in self._grid(part) if value <= best]
        for value in reversed(slower):
            yield from self._within(part, {**values, gene: value})
        for share in observed.SHARES if slower else ():
            whole = {**values, gene: slower[0]}
            shared = {"share": share} if "share" in whole else self.bench.law.share(whole, share)
            yield from self._within(part, {**whole, **shared})

    def _kalman(self, order: int) -> DesignedObserver:
        """Return a disturbance observer of an order; raise ControlError when there is none."""
        if order not in self._designed:
            step, masses = self.bench.datasheet.encoder_step, self.masses
            designed = design_observer(self.bench.loop, step, self.F_c, masses=masses, order=order)
            self._designed[order] = designed
        return self._designed[order]

    def _within(self, part: Part, values: Mapping[str, float]) -> Iterator[observed.ObserverDesign]:
        """Yield an observer if its peak sensitivity is within the limit while it acts."""
        peaks = [response.peak for response in self._measured(part, values)]
        if peaks and max(peaks) <= offer.SENSITIVITY:
            first = next(iter(self._onsets(part)), {})
            observer = Compensator("observer", part.model, {**values, **first})
            observer = replace(observer, values=observer.parameters(self.bench.loop))
            yield observed.ObserverDesign(observer, max(peaks), self._without)

    def _onsets(self, part: Part) -> Sequence[Mapping[str, float]]:
        """Return the values of ``onset``, if the model of a part has one, to be tried in turn."""
        if not any(one.name == "onset" for one in models.load_model(part.model).variables):
            return ()
        return [{"onset": one} for one in self.bench.onsets]

    def _grid(self, part: Part) -> list[float]:
        """Return values of the first gene of a part."""
        low, _, high = next(iter(part.ranges.values()))
        return [float(value) for value in np.geomspace(low, high, GRID)]

    def _searched(self, part: Part, values: Mapping[str, float]) -> float:
        """Return the first gene with the least product of Ms and error; 0 where none is better."""
        gene, *_ = part.ranges
        weights = self.bench.datasheet.encoder_step, self.F_c, FORCE_NOISE * self.F_c

        def cost(responses: Sequence[Response]) -> float:
            both = zip(self._axes, responses, strict=True)
            error = max(expected_errors(*one, *weights)[0] for one in both)
            return error * max(response.peak for response in responses)

        least, best = cost([axis.response() for axis in self._axes]), 0.0
        for value in self._grid(part):
            responses = self._measured(part, {**values, gene: value})
            if not responses or max(one.peak for one in responses) > offer.SENSITIVITY:
                continue
            if (found := cost(responses)) < least:
                least, best = found, value
        return best

    def _measured(self, part: Part, values: Mapping[str, float]) -> list[Response]:
        """Return the responses of the loop with an observer at all masses; none if unstable."""
        if part.model not in self._responses:
            chain = [Compensator("observer", part.model, values)]
            folder = self.bench.fmus(self.bench.law.name, chain)
            response = ChainResponse(folder, self.bench.loop, chain, self.speed)
            self._responses[part.model] = self.enter_context(response)
        given = {f"observer.{name}": value for name, value in values.items()}
        return self._responses[part.model].responses(self._axes, given, self.F_c)

    def _values(self, part: Part, *, alone: bool = False) -> dict[str, float]:
        """Return values of a part: those of the arena, scaled, and what was learned.

        An observer of the amplitude of Coulomb friction starts, alone, with the least friction on
        which it is tried, so that it never gives too much.
        """
        found = dict(part.values)
        for gene in part.genes(Coarse(self.F_c, self.speed)):
            found[gene.name.partition(".")[2]] = gene.start
        found |= {name: self.friction[name] for name in part.friction}
        if part.design:
            found = {name: found[name] for name in found if name not in ("rate", "noise")}
        if "share" in found:
            found["share"] = 1.0
        if _RAMP in found:
            found[_RAMP] *= self._ramp
            if alone and part.ports is not None and "a_0" in part.ports.learned:
                found["a_0"] = min(one.level for one in self.bench.drives) * self.F_c
        return found

    @cached_property
    def _ramp(self) -> float:
        """Factor on the velocity at which the ramp of a Coulomb force ends, best on few drives."""
        part = parts()["static"]
        start = part.ranges[_RAMP][1] * Coarse(self.F_c, self.speed).scale("m/s")
        fixed = {"F_c": self.F_c, "asymmetry": 0.0}
        ratios = {
            k: self.bench.quick_ratio(
                feedforward({**fixed, _RAMP: k * start}, "", part.model), QUICK
            )
            for k in RAMPS
        }
        return min(RAMPS, key=lambda k: ratios[k])

    @cached_property
    def _axes(self) -> list[OpenLoop]:
        loop = self.bench.loop
        return [OpenLoop(loop, k * loop.axis.m, frequencies(loop)) for k in self.masses]

    @cached_property
    def _without(self) -> float:
        return max(axis.response().peak for axis in self._axes)
