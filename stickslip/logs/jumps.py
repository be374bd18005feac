"""Steps of a signal that no motion makes: counters that restart, lost samples, new zero points."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.fmi.messages import quantity
from stickslip.logs.finding import Finding
from stickslip.logs.recording import Motion
from stickslip.logs.steps import step_of
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array
from stickslip.thresholds import log_clock, log_jump

AROUND = 17  # steps around one, with itself
WORDS = tuple(2.0**n for n in range(8, 33))  # counts after which a counter restarts


def jumps(t: Array, x: Array) -> tuple[NDArray[np.intp], Array, Array]:
    """Return after which samples (k,) a signal jumps, how far, and the tolerance of that (k,).

    Parameters
    ----------
    t, x : (n,), times that rise, and the signal
    """
    steps, times = np.diff(x), np.diff(t)
    near = steps / times
    beside = [near[:-4], near[1:-3], near[3:-1], near[4:]]
    off = np.zeros(len(steps))  # the two at each end have too few neighbours
    off[2:-2] = steps[2:-2] - np.median(beside, axis=0) * times[2:-2]
    usual = scipy.ndimage.percentile_filter(np.abs(off), 75, size=AROUND)
    noise = log_jump.STANDS_OUT * (usual + 2.0 * step_of(x))
    stands_out = np.abs(off) > noise
    largest = float(np.max(np.abs(steps[2:-2][~stands_out[2:-2]]), initial=0.0))
    found = np.flatnonzero(stands_out & (np.abs(off) > log_jump.FAR * largest))
    return found, off[found], noise[found]


def continuous(
    table: LogTable, t: Array, signals: dict[str, Array], motion: Motion, findings: list[Finding]
) -> dict[str, Array]:
    """Return signals (n,) by role without restarts of counters, and NaN for samples that are lost.

    A position that jumps otherwise is an error among the findings.
    """
    signals = dict(signals)
    unit = "rad" if motion == "rotary" else "m"
    for role, per in (("position", unit), ("velocity", f"{unit}/s"), ("force", "")):
        if role not in signals:
            continue
        known = np.flatnonzero(np.isfinite(signals[role]))
        at, sizes, tolerance = jumps(t[known], signals[role][known])
        if not at.size:
            continue
        round_ = None if role == "force" else _restart(role, signals[role], sizes, tolerance)
        if round_ is None:
            lost, rest = _lost(at, sizes, tolerance)
            _blank(table, role, known[lost], signals, findings=findings)
            at, sizes, tolerance = at[rest], sizes[rest], tolerance[rest]
            if role != "force" and at.size:
                round_ = _restart(role, signals[role], sizes, tolerance)
        if round_ is not None:
            times, first = _unwrap(role, round_, signals)
            figure = f"{quantity(round_, per, 6)}, {times} times, the first in row "
            figure += f"{table.row(first)}"
            findings.append(Finding("note", f"{role} restarts, and was counted on", figure))
        elif role == "position" and at.size:
            findings.append(_jumped(table, t, known[at], sizes, unit=per))
    return signals


def _restart(role: str, x: Array, sizes: Array, tolerance: Array) -> float | None:
    """Return the size after which a counter restarts, None if the jumps have none in common."""
    if not sizes.size:
        return None
    size, slack = float(np.median(np.abs(sizes))), float(np.max(tolerance))
    step = step_of(x)
    words = [word * step for word in WORDS if step and abs(word * step - size) <= slack]
    turn = [2.0 * np.pi] if abs(size - 2.0 * np.pi) <= min(slack, 0.1) else []
    if (
        np.any(np.abs(np.abs(sizes) - size) > np.maximum(log_jump.EQUAL * size, tolerance))
        or np.nanmax(x) - np.nanmin(x) > size + slack
        or (len(sizes) < log_jump.FEWEST and not words and not turn)
        or (role == "velocity" and not words)
    ):
        return None
    if exact := [*turn, *words]:
        return float(exact[0])
    if step:
        return float(round(size / step) * step)
    digits = next(d for d in range(1, 17) if abs(float(f"{size:.{d}g}") - size) <= slack / 100)
    return float(f"{size:.{digits}g}")


def _unwrap(role: str, size: float, signals: dict[str, Array]) -> tuple[int, int]:
    """Count a signal on, and a position's command, which restarts elsewhere.

    Returns how many times it restarts, and the first sample behind that.
    """
    signal = signals[role].copy()
    known = np.flatnonzero(np.isfinite(signal))
    restarts = np.flatnonzero(np.abs(np.diff(signal[known])) > 0.5 * size)
    signal[known] = np.unwrap(signal[known], period=size)
    if role == "velocity":  # most are as logged; a position is where it began
        signal += size * np.nanmedian(np.round((signals[role] - signal) / size))
    signals[role] = signal
    command = signals.get("position_command") if role == "position" else None
    if command is not None:
        off = command - signal
        signals["position_command"] = command - size * np.round(off / size)
    return restarts.size, int(known[restarts[0] + 1])


def _lost(
    at: NDArray[np.intp], sizes: Array, tolerance: Array
) -> tuple[NDArray[np.intp], NDArray[np.bool_]]:
    """Return the samples between jumps there and back, and which jumps (k,) are others."""
    lost: list[int] = []
    rest = np.ones(len(at), dtype=bool)
    for k in range(len(at) - 1):
        back = abs(sizes[k] + sizes[k + 1]) <= max(log_jump.BACK * abs(sizes[k]), tolerance[k])
        if rest[k] and back and at[k + 1] - at[k] <= log_clock.FILLED:
            rest[k : k + 2] = False
            lost += range(at[k] + 1, at[k + 1] + 1)
    return np.array(lost, dtype=np.intp), rest


def _blank(
    table: LogTable,
    role: str,
    lost: NDArray[np.intp],
    signals: dict[str, Array],
    findings: list[Finding],
) -> None:
    """Put NaN where samples are lost; where other signals are 0, too, the row is."""
    if role == "force":  # a force may jump there and back, but not to 0
        lost = lost[signals[role][lost] == 0.0]
    if not lost.size:
        return
    zero = lost[signals[role][lost] == 0.0]
    for other in signals:
        signals[other] = signals[other].copy()
        signals[other][zero[signals[other][zero] == 0.0]] = np.nan
    signals[role][lost] = np.nan
    figure = f"{lost.size}, the first in row {table.row(int(lost[0]))}"
    what = f"{role}: samples are lost, which jump there and back"
    findings.append(Finding("warning", what, figure, "filled in"))


def _jumped(table: LogTable, t: Array, at: NDArray[np.intp], sizes: Array, unit: str) -> Finding:
    """Return the error of a position that jumps, with the longest part that does not."""
    first = int(np.argmax(np.abs(sizes)))
    figure = f"by {quantity(float(sizes[first]), unit, 4)} in row {table.row(int(at[first]) + 1)}"
    if at.size > 1:
        figure += f", and {at.size - 1} times more"
    edges = np.concatenate([[0], at + 1, [len(t)]])
    k = int(np.argmax(np.diff(edges)))
    span = t[[edges[k], edges[k + 1] - 1]] + np.mean(np.diff(t)) * np.array([2.0, -2.0])
    advice = f"cut the log there; --span {span[0]:.9g} {span[1]:.9g} is its longest part"
    return Finding("error", "the position jumps, as no drive can", figure, advice)
