"""What lies between the force that moves a drive and the force that its log shows.

Each change of the force that logs show is tried on a rigid drive with Coulomb and viscous friction
while it slides: a limit that the log lacks, a limit that only the log has, and a low-pass.
"""

from collections.abc import Iterator

import numpy as np
import scipy

from stickslip.logs.motion import Delay, kinematics, left, rigid, rigid_columns
from stickslip.logs.recording import Finding, Recording
from stickslip.servo.measurement import Array, filter_by_section, smoothed
from stickslip.thresholds import log_content, log_force

LEVELS = (0.5, 0.6, 0.7, 0.75, 0.8, 0.85, 0.9, 0.925, 0.95, 0.97, 0.98, 0.99, 0.995)
"""Quantiles of the force that are tried as a limit."""
LAGS = np.geomspace(0.5, 100.0, 20)  # time constants of a low-pass that are tried [samples]
OWN = (0.0, 0.5, 0.7, 0.85, 1.0)  # shares of a low-pass's time constant that are tried as its delay


def force_path(recording: Recording, delay: Delay | None) -> Iterator[Finding]:
    """Yield how the logged force, of a short delay, differs from that which moves the drive."""
    force = recording.force
    if force is None:
        return
    both_or_one_way = (np.abs(force), force, -force)
    clipped = next(filter(None, (_clipped(recording, one) for one in both_or_one_way)), None)
    limits = (_before_limit(recording, force), clipped)
    # A limit delays the force, too.
    yield from filter(None, limits if any(limits) else [_low_passed(recording, delay)])


def _before_limit(recording: Recording, force: Array) -> Finding | None:
    """Return a finding where the motion shows a limit that the logged force does not have."""
    motion = kinematics(recording)
    if (drive := rigid(recording, motion)) is None:
        return None
    limits = np.quantile(np.abs(force), LEVELS)
    clipped = (
        smoothed(recording.moving(np.clip(force, -at, at)), recording.T_s, motion.cutoff)[
            drive.used
        ]
        for at in limits
    )
    rests = [left(drive.columns, one) for one in clipped]
    best = int(np.argmin(rests))
    whole = left(drive.columns, drive.force[drive.used])
    if best == 0 or not rests[best] < log_force.LIMITED * whole:
        return None
    share = float(np.mean(np.abs(force) > limits[best]))
    figure = f"{np.abs(force).max():.4g}, while the motion shows at most {limits[best]:.4g}"
    advice = "log it behind the limit, or the current"
    what = "the force was logged before a limit"
    return Finding("warning", what, f"{figure}; {share:.1%} of the time", advice, spoils="values")


def _clipped(recording: Recording, force: Array) -> Finding | None:
    """Return a finding where the motion shows more force than the log's largest, which piles up.

    A rigid drive is fitted where the force is below that, and not at its other extreme, which may
    be a plateau, too. One that is fitted to all samples must explain these worse, as it does not
    where the largest force is that of a drive at constant speed, or one that was commanded.
    """
    least, limit = np.quantile(force, (0.001, 0.999)).tolist()
    at = force > (1.0 - log_force.AT_LIMIT) * limit
    extreme = at | (force < (1.0 - log_force.AT_LIMIT) * least)
    motion = kinematics(recording)
    if np.mean(at) < log_force.PILED or (drive := rigid(recording, motion)) is None:
        return None
    reach = max(1, round(0.5 / (motion.cutoff * recording.T_s)))
    near = np.convolve(extreme, np.ones(2 * reach + 1), mode="same") > 0.5
    below, above = ~near[drive.used], at[drive.used]
    if min(below.sum(), above.sum()) < log_content.SLIDING:
        return None
    used = drive.force[drive.used]
    fit, every = (
        np.linalg.lstsq(drive.columns[part], used[part], rcond=None)[0]
        for part in (below, np.ones_like(below))
    )
    shown = float(np.mean(np.abs(drive.columns[above] @ fit)))
    rest, whole = (
        float(np.sum((used[below] - drive.columns[below] @ one) ** 2)) for one in (fit, every)
    )
    least = (1.0 + log_force.BEYOND) * float(np.mean(np.abs(used[above])))
    if shown < least or rest > log_force.LIMITED * whole:
        return None
    figure = f"{limit:.4g} for {np.mean(at):.1%} of the time, while the motion shows {shown:.4g}"
    advice = "log it with a larger range, or a gentler motion"
    what = "the force in the log is cut off"
    return Finding("warning", what, figure, advice, spoils="values")


def _low_passed(recording: Recording, delay: Delay | None) -> Finding | None:
    """Return a finding where a low-pass explains the force better than a delay does.

    A low-pass takes the steps of a coarse encoder out of the motion, too. That explains the force
    as well on a sound log, but no better than the same low-pass on motion and force does.
    """
    motion = kinematics(recording)
    if (drive := rigid(recording, motion)) is None:
        return None
    late = delay.value if delay and not delay.at_bound else 0.0
    spline, t = scipy.interpolate.CubicSpline(recording.t, drive.force), recording.t[drive.used]
    every = rigid_columns(motion, recording.T_s)
    force = spline(recording.t + late)
    [plain], [mass] = _fitted(drive.columns, force[drive.used, None])
    whole = float(np.sum(drive.force[drive.used] ** 2))
    if mass <= 0.0 or plain <= log_force.EXACT**2 * whole:  # else of a drive that hardly slides
        return None
    trials = []
    for lag in LAGS:
        share = -np.expm1(-1.0 / lag)
        section = np.array([share, 0.0, 0.0, 1.0, share - 1.0, 0.0])
        both = filter_by_section(section, np.column_stack([every, force]).T).T
        delayed, alike = both[drive.used, :-1], both[drive.used, -1]
        shifted = [spline(t + late - own * lag * recording.T_s) for own in OWN]
        (filtered, *rests), (_, *masses) = _fitted(delayed, np.column_stack([alike, *shifted]))
        trials += [(*one, lag, filtered) for one in zip(rests, masses, strict=True)]
    rest, unfiltered, lag, filtered = min(trials)
    if not _is_low_pass(rest, plain, filtered, abs(unfiltered / mass - 1.0)):
        return None
    frequency = 1.0 / (2.0 * np.pi * lag * recording.T_s)
    figure = (
        f"at {frequency:.2g} Hz, which explains {1.0 - rest / plain:.0%} of what is unexplained"
    )
    advice = "log it without a filter, or position and command with the same"
    what = "the force in the log is low-passed"
    return Finding("warning", what, figure, advice, spoils="intervals")


def _is_low_pass(rest: float, plain: float, filtered: float, change: float) -> bool:
    """Tell whether a low-pass, with its rest, explains the force, and changes the mass."""
    most = min(log_force.LAGGED * plain, log_force.LAGGED_ALIKE * filtered)
    return rest <= most and change >= log_force.ATTENUATED


def _fitted(columns: Array, forces: Array) -> tuple[Array, Array]:
    """Return the sums of squares [N^2] that columns (k, 4) leave of forces (k, c), and masses."""
    fits = np.linalg.lstsq(columns, forces, rcond=None)[0]
    return np.sum((forces - columns @ fits) ** 2, axis=0), fits[0]
