"""Force that a fitted law leaves where it was not fitted, and the causes that were tested."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from stickslip.identification.selection.candidates import candidates
from stickslip.identification.selection.choice import choose, is_better
from stickslip.identification.selection.prediction import Prediction
from stickslip.logs import Finding
from stickslip.thresholds import misfit


@dataclass(frozen=True)
class Cause:
    """A possible cause of the unexplained force, tested."""

    name: str  # of the cause, with its figure, such as ``another law, GMS``
    left: float  # root mean square of the held-out error when the cause is taken into account [N]
    advice: str  # what to do if it is the cause


def is_mismatch(found: Prediction) -> bool:
    """Tell whether a law leaves more force than noise and steps explain."""
    return found.ratio > misfit.NOTED and found.unexplained > misfit.SMALLEST * found.measured


def is_large(found: Prediction) -> bool:
    """Tell whether a law leaves so much of the force that the others are to be tried."""
    return is_mismatch(found) or found.relative > misfit.LARGE


def is_beaten(found: Prediction, others: Sequence[Prediction]) -> bool:
    """Tell whether another law predicts much better, whatever noise seems to explain.

    The drive of a wrong law may oscillate when it is simulated, which looks like noise.
    """
    return any(one.force < misfit.BEATEN * found.force and is_better(one, found) for one in others)


def mismatch(
    found: Prediction, others: Sequence[Prediction], causes: Sequence[Cause], *, rotary: bool
) -> Iterator[Finding]:
    """Yield the finding that a law does not explain a recording, with the figure of each cause.

    Parameters
    ----------
    others : predictions of the other laws that were tried; the best is one of the causes
    causes : further causes that were tested
    """
    unit = "N m" if rotary else "N"
    if found.fails and found.moving:
        yield Finding(
            "warning",
            f"the law {found.candidate.title} predicts the force of the moving drive worse than "
            "Coulomb and viscous friction alone",
            f"error of {found.moving.law:.3g} {unit} where it was not fitted, a regression leaves "
            f"{found.moving.regression:.3g} {unit}",
            "give --law auto",
            spoils="values",
        )
    if not (is_mismatch(found) or is_beaten(found, others)):
        return
    tested = sorted((*causes, *_another_law(found, others)), key=lambda cause: cause.left)
    figure = (
        f"error of {found.force:.3g} {unit} where it was not fitted, {100.0 * found.relative:.2g} "
        f"% of the force; noise and steps explain {found.explained:.3g} {unit}"
    )
    if tested:
        left = ", ".join(f"{cause.name} leaves {cause.left:.3g} {unit}" for cause in tested)
        figure += f"; causes tested: {left}"
    likely = [cause for cause in tested if _removes(cause, found) > misfit.LIKELY]
    advice = likely[0].advice if likely else "take the values as coarse"
    yield Finding(
        "warning",
        f"the law {found.candidate.title} does not explain the force",
        figure,
        advice,
        spoils="intervals" if is_beaten(found, others) or found.ratio > misfit.SPOILED else "",
    )


def _another_law(found: Prediction, others: Sequence[Prediction]) -> Iterator[Cause]:
    """Yield the law that would be chosen, if it predicts better than the one found."""
    if not others:
        return
    order = [*candidates(), found.candidate].index
    ordered = sorted((found, *others), key=lambda one: order(one.candidate))
    best = choose(ordered).chosen if ordered[0].candidate.is_level else min(ordered, key=_force)
    if best is not found and is_better(best, found):
        law = "auto" if best.candidate.is_level else best.candidate.law.name
        yield Cause(f"another law, {best.candidate.title},", best.force, f"give --law {law}")


def _force(one: Prediction) -> float:
    return one.force


def _removes(cause: Cause, found: Prediction) -> float:
    """Return the share of the unexplained mean square that a cause removes."""
    if cause.left >= found.force:
        return 0.0
    floor = min(found.explained, cause.left)
    return (found.force**2 - cause.left**2) / (found.force**2 - floor**2)
