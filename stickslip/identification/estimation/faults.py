"""Faults that the estimation finds, and whether its law predicts what it was not fitted to."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from stickslip.catalog.parameters import DRIVE, Values
from stickslip.identification.criteria.controller_check import ControllerCheck
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import OutputError
from stickslip.identification.criteria.motion import Scale
from stickslip.identification.estimation.task import Task
from stickslip.identification.fitting.fit import Fit
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE, Identifiability
from stickslip.identification.selection import prediction
from stickslip.identification.selection.choice import Cause, along_the_travel, is_large, mismatch
from stickslip.logs import Finding
from stickslip.thresholds import loop_fit, misfit

SLIDING = 0.3  # share of the highest speed above which the drive slides
LIKE = 40  # classes of velocity
SPANS = 10  # parts of a recording that are left out in turn for that standard error
LEAST = 0.01  # smallest share of a fitted value that a parameter may have which a fault hides


def found_faults(
    fitted: Fit,  # by the criterion of that name
    criterion: str,
    check: ControllerCheck | None,  # of the controller; None where it is not known
    model_error: float,  # residual of the loop over that from encoder and noise
    change: tuple[float, float],  # what ``change_of_friction`` found
    delay_error: float,  # standard error of the delay [s]
    bent: float,  # presliding deflection over the travel
) -> Iterator[Finding]:
    """Yield each fault, with its figure and what to do."""
    u = fitted.space
    index = u.index("delay")
    delay, low, high = (float(q[index]) for q in (fitted.q, u.lower, u.upper))
    near, known = loop_fit.DELAY_AT_BOUND, loop_fit.DELAY_KNOWN
    at_low = delay - low < near and criterion != OutputError.name  # no lag is a drive without one
    if at_low or high - delay < near:
        figure = f"{delay:.3g} samples or {1e3 * delay * u.units[index]:.3g} ms"
        advice = "log force and position of the same instants, or shift the force by its delay"
        what = "the delay of the force ends at the bound of the fit"
        yield Finding("warning", what, figure, advice, spoils="intervals")
    if criterion != OutputError.name and (error := delay_error / u.units[index]) > known:
        what, figure = (
            "the delay of the force is hardly known",
            f"{delay:.2g} +-{error:.2g} samples",
        )
        advice = "log a motion with more acceleration and reversals"
        yield Finding("warning", what, figure, advice, spoils="intervals")
    if bent > loop_fit.SPRING:
        what, figure = "friction turns over much of the travel", f"{100.0 * bent:.2g} % of it"
        advice = "log longer moves; a spring or a cable passes for friction"
        hides = ("F_c", "F_s")
        yield Finding("warning", what, figure, advice, spoils="intervals", hides=hides)
    law = u.law
    if criterion == OutputError.name and not law.is_smooth and model_error > misfit.EXPLAINED:
        what = f"the simulated loop with the law {law.title} does not follow the recording"
        figure = f"its residual is {misfit.excess(model_error)}"
        yield Finding("warning", what, figure, "take the values as coarse", spoils="intervals")
    drift, error = change
    if abs(drift) > max(loop_fit.CHANGE, loop_fit.CHANGE_CERTAIN * error):
        what = "friction changes over the recording"
        figure = f"by {100.0 * drift:+.2g} % from its beginning to its end, +-{100.0 * error:.2g} %"
        advice = "run the drive until it is warm, and log again; above 100 % it is another force"
        yield Finding("warning", what, figure, advice, spoils="intervals")
    if check is not None and check.factor != 1.0:
        what = "the logged force is out of scale with the force that the controller commands"
        what = check.source + what
        figure = f"{check.factor:.3g} times as large"
        advice = f"give <scale force={1.0 / check.factor:.3g}>, or correct its unit or the gains"
        yield Finding("warning", what, figure, advice, spoils="values")


def hidden(
    known: dict[str, Identifiability], faults: Iterable[Finding], strongest: float
) -> dict[str, Identifiability]:
    """Return the same without the parameters that faults hide: up to the largest force, all fit."""
    changed = dict(known)
    for fault in faults:
        for name in set(fault.hides) & set(known):
            one = known[name]
            template = f"{NOT_IDENTIFIABLE} in this experiment: {fault.what}"
            changed[name] = replace(
                one,
                low=LEAST * one.value,
                high=one.high if name in DRIVE else max(one.high, strongest),
                identifiability=NOT_IDENTIFIABLE,
                template=template,
            )
    return changed


def change_of_friction(inverse: InverseModel, values: Values) -> tuple[float, float]:
    """Return by how much friction changes from begin to end, and its standard error, relative.

    The force that the inverse model leaves in the direction of sliding has a slope over time where
    friction changes. Only instants of like velocity are compared, so a wrong law has none. The
    standard error is a jackknife over spans of the recording.
    """
    v = inverse.motion.v
    speed = np.abs(v)
    sliding = np.zeros(len(v), dtype=bool)
    sliding[inverse.used] = True
    sliding &= speed > SLIDING * np.quantile(speed, 0.99)
    ahead = np.sign(v)[sliding]
    left = (inverse.measured(values) - inverse.predicted(values))[sliding] * ahead
    time = np.linspace(-0.5, 0.5, len(v))[sliding]
    rows = np.column_stack([time, inverse.motion.a[sliding] * ahead, left])
    _, like = np.unique(
        np.searchsorted(np.quantile(v[sliding], np.linspace(0.0, 1.0, LIKE)[1:-1]), v[sliding]),
        return_inverse=True,
    )
    span = np.arange(len(left)) * SPANS // len(left)

    def slope(used: NDArray[np.bool_]) -> float:
        count = np.maximum(np.bincount(like[used], minlength=LIKE), 1)
        means = [np.bincount(like[used], column, LIKE) / count for column in rows[used].T]
        within = rows[used] - np.column_stack(means)[like[used]]
        return float(np.linalg.lstsq(within[:, :2], within[:, 2])[0][0])

    without = np.array([slope(span != k) for k in range(SPANS)])
    error = np.sqrt((SPANS - 1) * np.var(without))
    level = abs(float(np.mean(inverse.friction(values)[sliding] * ahead)))
    return slope(span >= 0) / level, float(error / level)


@dataclass(frozen=True)
class HeldOut:
    """What was found where the law was not fitted."""

    # of the law, and of all others that were tried [SI]
    predictions: tuple[prediction.Prediction, ...]
    findings: tuple[Finding, ...]  # that the law does not explain the recording


def check_held_out(
    inverse: InverseModel, found: Fit, task: Task, gains: Mapping[str, float] | None, scale: Scale
) -> HeldOut:
    """Predict, and test the causes of a mismatch: the position, and the other laws.

    What the inverse model found is of a recording that is scaled; the gains are those of a
    controller that commands the logged force.
    """
    candidate = prediction.Candidate(inverse.space.law, is_level=task.is_level)
    residual = prediction.held_out(inverse, found)
    own = prediction.predict(inverse, found, candidate, gains, residual=residual)
    tried = task.choice.predictions if task.choice else ()
    causes: list[Cause] = []
    if is_large(own):
        if not tried:
            further = [one for one in prediction.candidates() if one != candidate]
            others = prediction.predictions(task.recording, gains, further)
            tried = tuple(one.restored(scale) for one in others)
        place = along_the_travel(inverse, residual)
        causes = [replace(place, left=place.left / scale.force)]
    own = own.restored(scale)
    others = [one for one in tried if one.candidate != candidate]
    findings = mismatch(own, others, causes, rotary=task.recording.rotary)
    return HeldOut((own, *others), tuple(findings))
