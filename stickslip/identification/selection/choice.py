"""The choice of a friction law by what it predicts, and the causes of what none explains."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from stickslip.catalog.parameters import presliding
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.held_out import folds, is_less
from stickslip.identification.selection.prediction import Prediction, candidates, memory
from stickslip.logs import Finding
from stickslip.servo.measurement import Array
from stickslip.thresholds import law_choice, misfit

FORCE = attrgetter("force")
NO_LAW = (
    "none of the laws compared explains it; check sign, unit and delay of the force, and what else "
    "pushes the drive"
)


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
    """Yield the finding that a law does not explain a recording, with the figure of each cause."""
    unit, another = "N m" if rotary else "N", [*_another_law(found, others)]
    # A regression takes less mass where the acceleration is noisy, and so leaves less of the noise.
    if found.fails and found.moving and found.ratio > misfit.NOTED:
        yield Finding(
            "warning",
            f"the law {found.candidate.title} predicts the force of the moving drive worse than "
            "Coulomb and viscous friction alone",
            f"error of {found.moving.law:.3g} {unit} where it was not fitted, a regression leaves "
            f"{found.moving.regression:.3g} {unit}",
            another[0].advice if another else NO_LAW if others else "give <law auto>",
            spoils="values",
        )
    if not (is_mismatch(found) or is_beaten(found, others)):
        return
    tested = sorted((*causes, *another), key=lambda cause: cause.left)
    figure = (
        f"error of {found.force:.3g} {unit} where it was not fitted, {100.0 * found.relative:.2g} "
        f"% of the force and {misfit.excess(found.ratio)}"
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
        spoils="intervals" if is_beaten(found, others) or found.ratio > misfit.EXPLAINED else "",
    )


def _another_law(found: Prediction, others: Sequence[Prediction]) -> Iterator[Cause]:
    """Yield the law that would be chosen, if it predicts better than the one found."""
    if not others:
        return
    order = [*candidates(), found.candidate].index
    ordered = sorted((found, *others), key=lambda one: order(one.candidate))
    best = choose(ordered).chosen if ordered[0].candidate.is_level else min(ordered, key=FORCE)
    if best is not found and is_better(best, found):
        law = "auto" if best.candidate.is_level else best.candidate.law.name
        yield Cause(f"another law, {best.candidate.title},", best.force, f"give <law {law}>")


def _removes(cause: Cause, found: Prediction) -> float:
    """Return the share of the unexplained mean square that a cause removes."""
    if cause.left >= found.force:
        return 0.0
    floor = min(found.explained, cause.left)
    return (found.force**2 - cause.left**2) / (found.force**2 - floor**2)


PLACES = 60  # places along the travel; the force is linear between them
RIDGE = 10.0  # samples of no force that each place counts in addition
THIN = 4


def along_the_travel(inverse: InverseModel, residual: Array) -> Cause:
    """Return the cause, tested on a held-out residual (k,) [N].

    A function of the position for each direction is fitted to it, and predicts in turn the blocks
    that it was not fitted to.
    """
    every = slice(None, None, THIN)
    position = inverse.position[inverse.used][every]
    ahead = np.sign(inverse.motion.v[inverse.used][every])
    residual = residual[every]
    place = (position - position.min()) / max(float(np.ptp(position)), 1e-300) * (PLACES - 1)
    hats = np.maximum(1.0 - np.abs(place[:, np.newaxis] - np.arange(PLACES)), 0.0)
    rows = np.hstack([hats * (ahead[:, np.newaxis] > 0.0), hats * (ahead[:, np.newaxis] < 0.0)])
    left = residual.copy()
    for fold in folds(len(residual), memory(inverse) // THIN):
        fitted = rows[fold.fitted]
        square = fitted.T @ fitted + RIDGE * np.eye(2 * PLACES)
        force = np.linalg.solve(square, fitted.T @ residual[fold.fitted])
        left[fold.held_out] -= rows[fold.held_out] @ force
    return Cause(
        "a force that depends on position and direction",
        float(np.sqrt(np.mean(left**2))),
        "the friction learned is the mean along the travel",
    )


@dataclass(frozen=True)
class Choice:
    """The law that explains a recording."""

    predictions: tuple[Prediction, ...]  # of all candidates, in the order of preference
    chosen: Prediction  # one of them
    reason: str  # a sentence

    @property
    def alike(self) -> list[Prediction]:
        """The laws that predict about as well as the chosen one."""
        most = law_choice.ALIKE * self.chosen.force
        return [one for one in self.predictions if one.force <= most]


def choose(predictions: Sequence[Prediction]) -> Choice:
    """Choose the first of the laws that are tied with the one that predicts best.

    Coulomb and viscous friction is the first, LuGre the second. None is chosen that predicts worse
    than friction without presliding. A law with more parameters takes
    part only if the recording identifies one of them at least, or if it predicts much better: the
    best of several flexible models predicts a little better by chance; much better it is not tied
    with others, even if only in few blocks. A law that fails beside a regression takes no part.
    """
    simplest = predictions[0].force
    able = [
        one
        for one in predictions
        if one.candidate.is_level
        or ((one.shown or one.force < law_choice.UNIDENTIFIED * simplest) and not one.fails)
    ]
    best = min(able, key=FORCE)
    static = [one.force for one in predictions if not presliding(one.candidate.law)]
    most = law_choice.STATIC * min(static, default=best.force)
    most = min(most, best.force / law_choice.UNIDENTIFIED)
    tied = [one for one in able if one is best or (one.force <= most and not is_better(best, one))]
    chosen, others = tied[0], [one.candidate.title for one in tied[1:]]
    reason = f"{chosen.candidate.title}, by what it predicts of the parts held out"
    if chosen.candidate.is_level:
        reason += "; nothing more can be seen in this log: neither presliding nor a Stribeck curve"
    elif others:
        reason += f"; {' and '.join(others)} tie with it"
    return Choice(tuple(predictions), chosen, reason)


def is_better(one: Prediction, other: Prediction) -> bool:
    """Tell whether one predicts better, by the standard error over blocks."""
    return is_less(one.squares, other.squares)
