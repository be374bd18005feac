"""The constant force of each log, where several logs of a drive differ in it.

A sensor that was zeroed again, or another tilt of the axis, shows as a constant beside the friction
that all logs have in common. It is told from sliding in both directions.
"""

from dataclasses import replace

import numpy as np

from stickslip.identification.criteria.motion import measured_force, position_noise, position_of
from stickslip.identification.sliding.regression import regress
from stickslip.identification.sliding.rows import (
    DISTANCES,
    ENOUGH,
    GUARDS,
    KNOTS,
    SLOWEST,
    Rows,
    hats,
)
from stickslip.logs import Finding, Recording
from stickslip.thresholds import agreement, curve_shown, log_content


def with_log_offsets(recording: Recording) -> tuple[Recording, tuple[Finding, ...]]:
    """Return the recording whose known force holds what each log has beside the first, and a note.

    Only what is certain counts, of logs that slide both ways. The others count as the first.
    """
    is_measured = recording.force is None and recording.friction is not None
    if is_measured or not recording.joins_several:
        return recording, ()
    position, force, T_s = position_of(recording), measured_force(recording), recording.T_s
    q = max(2, len(position) // ENOUGH + 1)
    noise = position_noise(position, recording.encoder_step)
    rows = Rows(position, force, T_s, noise, logs=recording.segments, q=q, share=SLOWEST)
    used = rows.used(DISTANCES[0], GUARDS[0])
    ahead = rows.ahead[used]
    of = rows.belongs[used]
    count = of.sum(axis=0)
    forward = (of * (ahead[:, np.newaxis] > 0.0)).sum(axis=0)
    both = np.minimum(forward, count - forward) > log_content.ONE_WAY * count
    slide = np.flatnonzero(both).tolist()
    if len(slide) < 2 or len(used) < curve_shown.ROWS:
        return recording, ()
    size = float(np.std(rows.force[used]))
    speed = np.maximum(np.abs(rows.v), rows.slowest)
    places = np.log(np.geomspace(speed[used].min(), rows.top, KNOTS))
    over = rows.low(rows.ahead[:, np.newaxis] * hats(np.log(speed), places))[used]
    columns = (rows.a[used], rows.v[used], rows.low(rows.ahead[:, np.newaxis])[used, 0])
    fixed = np.column_stack([*columns, np.ones(len(used)), of[:, slide[1:]]])
    classes = np.argmax(of, axis=1)
    found = regress(rows.force[used], fixed, {"curve": size * over}, classes)
    own = slice(fixed.shape[1] - len(slide) + 1, fixed.shape[1])
    offsets = found.coefficients[own]
    errors = np.sqrt(np.diag(found.covariance)[own])
    friction = abs(float(found.coefficients[2]))
    least = np.maximum(agreement.CERTAIN * errors, agreement.DIFFERS * friction)
    known = np.zeros_like(position)
    told = []
    for k, offset, least_one in zip(slide[1:], offsets.tolist(), least.tolist(), strict=True):
        one = recording.segments[k]
        if abs(offset) > least_one:
            known[one.begin : one.end] = offset
            told.append(f"{one.source} {offset / friction:+.3g} F_c")
    if not told:
        return recording, ()
    whole = known if recording.known_force is None else recording.known_force + known
    what = f"the constant force differs from that of {recording.segments[slide[0]].source}"
    return replace(recording, known_force=whole), (Finding("note", what, ", ".join(told)),)
