"""An observer beside the learned feedforward, tried on the same family of drives.

The observer corrects what the feedforward leaves, or takes its place. It is designed for the
learned mass and all of its interval, at least 10 %, as fast as sensitivity and quantisation allow.
Where that is worse than no compensation on any drive, it is designed slower, for less friction,
and then only a share of its estimate is compensated.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Final, Literal

from stickslip.servo.axis import ControlError
from stickslip.servo.observer import DesignedObserver, design_observer
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.systems import Compensator
from stickslip.servo.velocity_filter import Observer
from stickslip.thresholds import offer
from stickslip.trial.guards import Bench, Benefit, TrialError, Variant

SLOWER = 0.3  # share of the Coulomb friction for which a slower observer is designed
SHARES = (0.7, 0.5, 0.35, 0.25, 0.15)  # shares of its estimate that are tried after that
FEEDFORWARD: Final = "feedforward"
OBSERVER: Final = "observer"
BOTH: Final = "feedforward + observer"
Choice = Literal["feedforward", "observer", "feedforward + observer", ""]


@dataclass(frozen=True)
class ObserverDesign:
    """An observer that was designed."""

    observer: Compensator  # its component
    sensitivity: float  # largest peak sensitivity at any of the masses, with the observer
    without: float  # the same without it


@dataclass(frozen=True)
class ObserverTrial:
    """What an observer adds to a feedforward."""

    feedforward: Benefit  # what the feedforward does there
    designed: ObserverDesign | None = None  # the observer, None where there is none
    reason: str = ""  # why there is none, empty otherwise
    alone: Benefit | None = None  # on the family of drives; None without it
    both: Benefit | None = None  # the same with the feedforward

    @property
    def parts(self) -> dict[Choice, Benefit]:
        """Feedforward, observer and both, those that were tried."""
        found: dict[Choice, Benefit | None] = {
            FEEDFORWARD: self.feedforward,
            OBSERVER: self.alone,
            BOTH: self.both,
        }
        return {name: benefit for name, benefit in found.items() if benefit is not None}

    @property
    def recommended(self) -> Choice:
        """What should be written: a feedforward if it is acceptable, with an observer that helps.

        The observer takes the place of a feedforward that is not acceptable, even where both
        together are, because a feedforward that is written may be used by itself.
        """
        if not self.feedforward.acceptable:
            return OBSERVER if self.alone and self.alone.acceptable else ""
        if self.both and self.both.acceptable:
            return BOTH if self.both.mean_ratio < self.feedforward.mean_ratio else FEEDFORWARD
        return FEEDFORWARD

    def refusal(self, choice: Choice) -> str:
        """Return why the observer is not written for a choice; empty where there is no reason."""
        if self.designed is None:
            return self.reason
        benefit = self.parts[choice if choice in (OBSERVER, BOTH) else BOTH]
        if not benefit.acceptable:
            return benefit.reason.replace("with the whole force ", f"with {benefit.variant.name} ")
        return "" if choice in (OBSERVER, BOTH) else "it does not reduce the mean tracking error"


def try_observer(
    bench: Bench, feedforward: Benefit, designs: Iterable[ObserverDesign]
) -> ObserverTrial:
    """Try observers, each weaker than the one before it, until one is acceptable.

    With a feedforward that is acceptable both together have to be, otherwise the observer alone.
    The feedforward is what is written without an observer, at its share.
    """
    together = feedforward.acceptable
    try:
        best, wanted = strongest(bench, feedforward, designs, together=together)
    except ControlError as error:
        return ObserverTrial(feedforward, reason=str(error))
    other = _tried(bench, feedforward, best.observer, together=not together)
    alone, both = (other, wanted) if together else (wanted, other)
    return ObserverTrial(feedforward, best, "", alone, both=both)


def strongest(
    bench: Bench, feedforward: Benefit, designs: Iterable[ObserverDesign], *, together: bool
) -> tuple[ObserverDesign, Benefit]:
    """Return the first acceptable observer, or the one with the least worst ratio, as tried.

    Raises ControlError when there is no observer. With ``together`` each is tried with the
    feedforward, at the share of that.
    """
    tried: list[tuple[TrialError, ObserverDesign, Benefit]] = []
    for designed in designs:
        variant = _variant(feedforward, designed.observer, together=together)
        shared = variant.share(bench.law, feedforward.share)
        if tried and bench.is_worse(shared, tried[-1][0]):
            continue
        benefit = _tried(bench, feedforward, designed.observer, together=together)
        tried.append((max(benefit.rows, key=lambda row: row.ratio), designed, benefit))
        if benefit.acceptable:
            break
    if not tried:
        raise ControlError("no observer")
    _, best, benefit = min(tried, key=lambda one: one[0].ratio)
    return best, benefit


def kalman_designs(
    bench: Bench, F_c: float, masses: tuple[float, ...], order: int = 1
) -> Iterator[ObserverDesign]:
    """Yield disturbance observers from fast to weak; raise ControlError when there is none.

    Parameters
    ----------
    F_c : Coulomb friction, as fitted [N]
    masses : true masses, relative to that of the axis, at which the limit of Ms holds
    order : of the disturbance
    """

    def designed(friction: float) -> DesignedObserver:
        step = bench.datasheet.encoder_step
        return design_observer(bench.loop, step, friction, masses=masses, order=order)

    slowest = designed(F_c)
    without = slowest.without
    yield _designed(slowest.observer, slowest.sensitivity, without)
    with suppress(ControlError):
        slowest = designed(SLOWER * F_c)
        yield _designed(slowest.observer, slowest.sensitivity, slowest.without)
    for share in SHARES:
        observer = replace(slowest.observer, share=share)
        peak = max(peak_sensitivity(bench.loop, observer, k * bench.loop.axis.m) for k in masses)
        if peak <= offer.SENSITIVITY:
            yield _designed(observer, peak, without)


def _designed(observer: Observer, sensitivity: float, without: float) -> ObserverDesign:
    return ObserverDesign(
        Compensator("observer", "dob", observer.parameters()), sensitivity, without
    )


def _variant(feedforward: Benefit, observer: Compensator, *, together: bool) -> Variant:
    """Return an observer alone, or together with the feedforward at its whole force."""
    if together:
        return Variant(BOTH, (*feedforward.variant.chain, observer))
    return Variant(OBSERVER, (observer,))


def _tried(bench: Bench, feedforward: Benefit, observer: Compensator, *, together: bool) -> Benefit:
    """Try an observer: with a feedforward at its share where that is acceptable, else at any."""
    variant = _variant(feedforward, observer, together=together)
    if not (variant.has_feedforward and feedforward.acceptable):
        return bench.benefits([variant])[0]
    shared = variant.share(bench.law, feedforward.share)
    (benefit,) = bench.benefits([shared], shares=(1.0,))
    return replace(benefit, variant=variant, share=feedforward.share)
