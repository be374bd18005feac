"""Observers beside a feedforward or in its place, tried on the same family of drives.

An observer is designed for the learned mass and all of its interval, at least 10 %, as fast as
sensitivity and quantisation allow. Where that is worse than no compensation, it is designed slower,
for less friction, and then only a share of its estimate is compensated.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

from stickslip.servo.axis import ControlError
from stickslip.servo.systems import Compensator
from stickslip.trial.benefit import Bench, Benefit, MotionErrors, Variant

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

    def changed(self, values: Mapping[str, float]) -> "ObserverDesign":
        """Return the same with other values of the observer that do not act in the linear loop."""
        observer = replace(self.observer, values={**self.observer.values, **values})
        return replace(self, observer=observer)


def strongest(
    bench: Bench, feedforward: Benefit, designs: Iterable[ObserverDesign], *, together: bool
) -> tuple[ObserverDesign, Benefit]:
    """Return the first acceptable observer, or the one with the least worst ratio, as tried.

    Raises ControlError when there is no observer. With ``together`` each is tried with the
    feedforward, at the share of that.
    """
    tried: list[tuple[MotionErrors, ObserverDesign, Benefit]] = []
    for designed in designs:
        variant = Variant(OBSERVER, (designed.observer,))
        if together:
            variant = Variant(BOTH, (*feedforward.variant.chain, designed.observer))
        shared = variant.share(bench.law, feedforward.share)
        if tried and bench.is_worse(shared, tried[-1][0]):
            continue
        if variant.has_feedforward and feedforward.acceptable:
            (benefit,) = bench.benefits([shared], shares=(1.0,))
            benefit = replace(benefit, variant=variant, share=feedforward.share)
        else:
            (benefit,) = bench.benefits([variant])
        worst = max(benefit.motions, key=lambda one: one.worst.ratio)
        tried.append((worst, designed, benefit))
        if benefit.acceptable:
            break
    if not tried:
        raise ControlError("no observer")
    _, best, benefit = min(tried, key=lambda one: one[0].worst.ratio)
    return best, benefit
