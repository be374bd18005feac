"""The choice of a friction law by what it predicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from stickslip.catalog.parameters import unit_of
from stickslip.identification.selection.folds import is_less
from stickslip.identification.selection.prediction import Prediction
from stickslip.thresholds import law_choice


@dataclass(frozen=True)
class Choice:
    """The law that explains a recording."""

    predictions: tuple[Prediction, ...]  # of all candidates, in the order of preference
    chosen: Prediction  # one of them
    reason: str  # a sentence


def choose(predictions: Sequence[Prediction], *, rotary: bool = False) -> Choice:
    """Choose the first of the laws that are tied with the one that predicts best.

    Coulomb and viscous friction is the first, LuGre the second. A law with more parameters takes
    part only if the recording identifies one of them at least, or if it predicts much better: the
    best of several flexible models predicts a little better by chance. A law that fails
    beside a regression takes no part.
    """
    simplest = predictions[0].force
    able = [
        one
        for one in predictions
        if one.candidate.is_level
        or ((one.shown or one.force < law_choice.UNIDENTIFIED * simplest) and not one.fails)
    ]
    best = min(able, key=lambda one: one.force)
    tied = [one for one in able if not is_better(best, one)]
    chosen, others = tied[0], [one.candidate.title for one in tied[1:]]
    force = f"{chosen.force:.3g} {unit_of('F_c', rotary=rotary)}"
    reason = f"{chosen.candidate.title} predicts the parts held out within {force}"
    if chosen.candidate.is_level:
        reason += (
            ", and nothing more can be seen in this log: neither presliding nor a Stribeck curve"
        )
    elif others:
        reason += f"; {' and '.join(others)} tie with it"
    return Choice(tuple(predictions), chosen, reason)


def is_better(one: Prediction, other: Prediction) -> bool:
    """Tell whether one predicts better, by the standard error over blocks."""
    return is_less(one.squares, other.squares)
