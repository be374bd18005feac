"""What a prediction of another log says about a learned drive, in sentences."""

import math
from collections.abc import Iterator

import numpy as np

from stickslip.catalog.parameters import Values, unit_of
from stickslip.presentation.scale import Scale
from stickslip.studies.validate.log_prediction import FRICTION, Change, LogPrediction
from stickslip.thresholds import control_match, loop_fit, misfit, transfer

SIGNALS = {
    "force": "force, inverse model",
    "position": "position, loop simulated",
    "velocity": "velocity, loop simulated",
    "closed_loop_force": "force, loop simulated",
}
WORDS = {"m": "inertia", "b": "viscous friction", FRICTION: "friction", "F_0": "constant force"}


def change_scale(name: str, found: LogPrediction, values: Values) -> Scale:
    """Return the unit in which a change is told: of inertia and friction per cent."""
    if name in ("m", FRICTION):
        return Scale(100.0 / (values["m"] if name == "m" else 1.0), "%")
    return Scale(1.0, unit_of("b" if name == "b" else "F_c", rotary=found.recording.rotary))


def verdict(found: LogPrediction, values: Values) -> tuple[str, ...]:
    """Return whether the learned drive, with its values, holds for the log, then why."""
    force, changes = found.signals["force"], dict(material(found, values))
    share = f"{100.0 * force.relative:.3g} %"
    reasons = [_explained(name, one.ratio) for name, one in found.signals.items()]
    if changes:
        first = f"the drive of this log differs from the learned one; force error {share}"
    elif force.ratio <= misfit.EXPLAINED:
        first = f"the learned drive holds for this log; force error {share}"
        if any(one.ratio > misfit.EXPLAINED for one in found.signals.values()):
            first = f"the learned drive explains the force of this log, but not its loop; {share}"
    elif force.relative <= transfer.SMALL:
        first = f"the learned drive predicts the force of this log within {share}"
    else:
        first = f"the learned drive does not explain this log; force error {share}"
    reasons += [_sentence(name, change, found, values) for name, change in changes.items()]
    drift, error = found.drift
    if abs(drift) > max(loop_fit.CHANGE, loop_fit.CHANGE_CERTAIN * error):
        reasons.append(
            f"friction changes by {100.0 * drift:+.2g} % from begin to end of the log, "
            f"+-{100.0 * error:.2g} %"
        )
    check = found.check
    if check is not None and found.goodness.simulated is None:
        reasons.append(
            f"the loop, simulated, runs away: its velocity exceeds {loop_fit.RUNS_AWAY:g} times "
            "the largest commanded one, so there are no figures of it; check units and signs of "
            "the gains"
        )
    if check is not None and check.error > control_match.NEAR:
        reasons.append(
            f"the controller differs from the logged force by {check.difference}: its "
            "gains are others, or a compensator was running"
        )
    return (first, *reasons)


def _explained(name: str, ratio: float) -> str:
    by = "noise, encoder steps and intervals"
    if ratio <= misfit.EXPLAINED:
        return f"{SIGNALS[name]}: {by} explain the error"
    return f"{SIGNALS[name]}: the error is {misfit.excess(ratio, by)}"


def material(found: LogPrediction, values: Values) -> Iterator[tuple[str, Change]]:
    """Yield the changes that are significant and large enough to matter, with their names."""
    top = float(np.max(np.abs(found.goodness.velocity_recorded)))
    level = values["F_c"]
    least = {
        "m": transfer.MASS * values["m"],
        "b": transfer.VISCOUS * (level / top) if top else math.inf,
        FRICTION: transfer.FRICTION,
        "F_0": transfer.OFFSET * level,
    }
    for name, change in found.changes.items():
        is_significant = change.low > 0.0 or change.high < 0.0
        if is_significant and abs(change.value) > least[name]:
            yield name, change


def _sentence(name: str, change: Change, found: LogPrediction, values: Values) -> str:
    """Return what has changed, and by how much."""
    scale = change_scale(name, found, values)
    one = change.times(scale.factor)
    return (
        f"{WORDS[name]}: {one.value:+.3g} {scale.unit} against the learned, 95 % "
        f"[{one.low:.3g}, {one.high:.3g}]"
    )
