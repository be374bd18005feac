"""Whether the law of an estimation predicts what it was not fitted to, and if not, why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.scaling import Scale
from stickslip.identification.estimation.task import Task
from stickslip.identification.fitting.fit import Fit
from stickslip.identification.selection import (
    Candidate,
    Prediction,
    candidates,
    predict,
    predictions,
)
from stickslip.identification.selection.mismatch import Cause, is_large, mismatch
from stickslip.identification.selection.position import along_the_travel
from stickslip.identification.selection.prediction import held_out
from stickslip.logs import Finding


@dataclass(frozen=True)
class HeldOut:
    """What was found where the law was not fitted."""

    # of the law, and of all others where they were tried, in SI units
    predictions: tuple[Prediction, ...]
    findings: tuple[Finding, ...]  # that the law does not explain the recording


def check_held_out(
    inverse: InverseModel, found: Fit, task: Task, gains: Mapping[str, float] | None, scale: Scale
) -> HeldOut:
    """Predict, and test the causes of a mismatch: the position, and the other laws.

    Parameters
    ----------
    found : by the inverse model
    task : of a recording that is scaled
    gains : of a controller that commands the logged force
    scale : of the recording
    """
    candidate = Candidate(inverse.space.law, is_level=task.is_level)
    residual = held_out(inverse, found)
    own = predict(inverse, found, candidate, gains, residual=residual)
    tried = task.choice.predictions if task.choice else ()
    causes: list[Cause] = []
    if is_large(own):
        if not tried:
            further = [one for one in candidates() if one != candidate]
            tried = tuple(
                one.restored(scale) for one in predictions(task.recording, gains, further)
            )
        place = along_the_travel(inverse, task.recording, residual)
        causes = [replace(place, left=place.left / scale.force)]
    own = own.restored(scale)
    others = [one for one in tried if one.candidate != candidate]
    findings = mismatch(own, others, causes, rotary=task.recording.rotary)
    return HeldOut((own, *others), tuple(findings))
