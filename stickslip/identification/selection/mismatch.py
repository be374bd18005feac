"""Force that a fitted law leaves where it was not fitted, and the causes that were tested."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from stickslip.identification.selection.choice import is_better
from stickslip.identification.selection.prediction import Prediction
from stickslip.logs import Finding

NOTED, SPOILED = 1.5, 2.0
"""Ratios of the error to the one explained above which it is a warning, and spoils intervals."""
SMALLEST = 0.02
"""Unexplained force, as share of the measured one, that is not worth a warning."""
MOST = 0.5
"""Share of the unexplained mean square that a cause must remove to be named as the likely one."""


@dataclass(frozen=True)
class Cause:
    """A possible cause of the unexplained force, tested.

    Attributes
    ----------
    name : of the cause, with its figure, such as ``another law, GMS``
    left : root mean square of the held-out error when the cause is taken into account [N]
    advice : what to do if it is the cause
    """

    name: str
    left: float
    advice: str


def is_mismatch(found: Prediction) -> bool:
    """Tell whether a law leaves more force than noise and steps explain."""
    return found.ratio > NOTED and found.unexplained > SMALLEST * found.measured


def mismatch(found: Prediction, causes: Sequence[Cause], *, rotary: bool) -> Iterator[Finding]:
    """Yield the finding that a law does not explain a recording, with the figure of each cause."""
    if not is_mismatch(found):
        return
    unit = "N m" if rotary else "N"
    tested = sorted(causes, key=lambda cause: cause.left)
    figure = (
        f"error of {found.force:.3g} {unit} where it was not fitted, {100.0 * found.relative:.2g} "
        f"% of the force; noise and steps explain {found.explained:.3g} {unit}"
    )
    if tested:
        left = ", ".join(f"{cause.name} leaves {cause.left:.3g} {unit}" for cause in tested)
        figure += f"; causes tested: {left}"
    likely = [cause for cause in tested if _share(found, cause) > MOST]
    advice = likely[0].advice if likely else "take the values as coarse"
    yield Finding(
        "warning",
        f"the law {found.candidate.title} does not explain the force",
        figure,
        advice,
        spoils="intervals" if found.ratio > SPOILED else "",
    )


def another_law(found: Prediction, others: Sequence[Prediction]) -> Iterator[Cause]:
    """Yield the law that predicts best, if it predicts better than the one found."""
    best = min(others, key=lambda one: one.force, default=found)
    if best.candidate != found.candidate and is_better(best, found):
        name = best.candidate.title
        yield Cause(f"another law, {name},", best.force, f"give --law {best.candidate.law.name}")


def _share(found: Prediction, cause: Cause) -> float:
    return (found.force**2 - cause.left**2) / found.unexplained**2
