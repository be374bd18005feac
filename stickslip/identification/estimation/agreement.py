"""Whether the logs that are learned together are logs of one drive in one state.

Without the log that contradicts the others, these are explained much better. What of the drive
differs in it is then told by the values that the others give.
"""

from collections.abc import Iterator
from copy import copy

import numpy as np
from numpy.typing import NDArray

from stickslip.catalog.parameters import Values, covariance
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.fitting.fit import ROUGH, Fit, fit
from stickslip.logs import Finding
from stickslip.servo.measurement import Array, smoothed
from stickslip.thresholds import agreement, log_content

_RISE = "rise towards rest"  # which others may not show: it tells no drives apart
MOST = 6  # logs that are left out in turn: those that are explained worst


def contradictions(inverse: InverseModel, found: Fit) -> Iterator[Finding]:
    """Yield the logs that are not of the drive of the others, and what of it differs by how much.

    Each log is left out of the fit in turn. It contradicts the others where these are explained
    much better without it, by more than a small share of their force, and where clearly another
    mass, friction or constant force explains it. A law that fails in one kind of motion is no
    contradiction.
    """
    logs = inverse.recording.segments
    whole = _squares(inverse, found.parameters)
    left = list(range(len(logs)))
    while 2 * (len(left) - 1) >= len(logs):  # at least half of them stay
        gains = []
        for k in sorted(left, key=lambda k: -whole[k])[:MOST]:
            others = [j for j in left if j != k]
            values = _without(inverse, found, others)
            squares = _squares(inverse, values)
            gain = sum(whole[j] for j in others) / max(sum(squares[j] for j in others), 1e-300)
            gains.append((gain, k, values))
        gain, k, values = max(gains, key=lambda one: one[0])
        if gain < agreement.CONTRADICTS:
            return
        left.remove(k)
        force = inverse.measured(values)[_rows(inverse, left)]
        before = sum(whole[j] for j in left) / float(force @ force)
        differs, rest = _differences(inverse, values, k)
        if not differs and rest:
            return
        if before * (1.0 - 1.0 / gain) < agreement.MATTERS**2:
            return
        if rest > agreement.EXPLAINED**2 * before / gain:
            return
        whole = _squares(inverse, values)
        rest_of = f"the other {len(left)} logs" if len(left) > 1 else logs[left[0]].source
        figure = f"these are explained {np.sqrt(gain):.3g} times as well without it"
        if differs:
            figure += "; with their values, its " + ", its ".join(differs)
        yield Finding(
            "warning",
            f"{logs[k].source} contradicts {rest_of}",
            figure,
            "learn without it, or correct its force, units, load or gains",
            spoils="values",
            log=logs[k].source,
        )


def _rows(inverse: InverseModel, logs: list[int]) -> NDArray[np.intp]:
    """Return the rows that count and are those of some of the logs."""
    inside = np.zeros(len(inverse.t), dtype=bool)
    for k in logs:
        inside[inverse.logs[k]] = True
    counts = np.arange(len(inverse.t))[inverse.used]
    return counts[inside[counts]]


def _squares(inverse: InverseModel, values: Values) -> list[float]:
    """Return the sum of squares [N^2] that values leave of each log."""
    rest = inverse.measured(values) - inverse.predicted(values)
    return [float(np.sum(rest[_rows(inverse, [k])] ** 2)) for k in range(len(inverse.logs))]


def _without(inverse: InverseModel, found: Fit, others: list[int]) -> Values:
    """Return the values of a fit to some of the logs."""
    few = copy(inverse.over(found.space))
    few.used = _rows(inverse, others)
    return fit(few, [found.q], ROUGH).parameters


def _differences(inverse: InverseModel, values: Values, k: int) -> tuple[list[str], float]:
    """Return how mass, friction and constant force of a log differ, and what its own ones leave.

    The rise of friction towards rest is free. What is left is a mean square over that of the force;
    0 for a log of moves below break-away, which shows none of them.
    """
    used = _rows(inverse, [k])
    used = used[inverse.moves[used]]
    if len(used) < log_content.SLIDING:
        return [], 0.0
    level = {**values, **({"F_s": values["F_c"]} if "F_s" in values else {})}
    friction, even = (
        smoothed(inverse.friction(one), inverse.T_s, inverse.cutoff) for one in (values, level)
    )
    rigid = inverse.linear * [values["m"], values["b"], values["F_c"]]
    columns: dict[str, Array] = {"friction": even + rigid[:, 1]}
    if np.any((rise := friction - even)[used]):
        columns[_RISE] = rise
    force = inverse.measured(values)
    if np.std(rigid[used, 0]) > log_content.INERTIAL * np.std(force[used]):
        columns["mass"] = rigid[:, 0]
    if abs(np.mean(np.sign(inverse.motion.v[used]))) < 1.0 - log_content.ONE_WAY:
        columns["constant force"] = rigid[:, 2]
    else:
        force = force - values["F_0"]
    x = np.column_stack(list(columns.values()))[used]
    factors, *_ = np.linalg.lstsq(x, force[used], rcond=None)
    rest = force[used] - x @ factors
    errors = covariance(x, rest).diagonal() ** 0.5
    found = []
    for name, factor, error in zip(columns, factors.tolist(), errors.tolist(), strict=True):
        if name == "constant force":
            apart = shown = factor - values["F_0"] / values["F_c"]
            unit = "F_c more"
        else:
            apart, shown, unit = factor - 1.0, factor, "times as large"
        if name != _RISE and abs(apart) > max(agreement.DIFFERS, 2.0 * error):
            found.append(f"{name} is {shown:.3g} {unit} (+-{2.0 * error:.2g})")
    return found, float(rest @ rest) / float(force[used] @ force[used])
