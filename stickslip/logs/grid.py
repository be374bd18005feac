"""Resampling to an even grid: gaps filled or cut off, jitter removed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.errors import RecordingError
from stickslip.logs.finding import Finding, Severity
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array

FILLED = 5
"""Consecutive missing samples that are interpolated; where more are missing, the log is cut."""
EVEN = 0.01
"""Deviation of times from an even grid that is ignored, in sample periods."""
SHORTEST = 20
"""Fewest samples of a recording."""
MOST = 20_000
"""Number of samples on which the choice of an interpolation is based."""

Method = Literal["linear", "cubic"]


@dataclass(frozen=True, eq=False)
class Grid:
    """Signals at even times.

    Attributes
    ----------
    t : (n,) from 0 on [s]
    signals : (n,) by role
    findings : what was done to get there
    """

    t: Array
    signals: dict[str, Array]
    findings: list[Finding]


def check_times(table: LogTable, t: Array) -> None:
    """Check that times (n,) [s] are finite and rise.

    Raises
    ------
    RecordingError
        When not; names the row.
    """
    if (wrong := np.flatnonzero(~np.isfinite(t))).size:
        row = table.row(int(wrong[0]))
        raise RecordingError(f"{table.path}: row {row}: expected a time, got {t[wrong[0]]}")
    if (wrong := np.flatnonzero(np.diff(t) <= 0)).size:
        k = int(wrong[0])
        raise RecordingError(
            f"{table.path}: row {table.row(k + 1)}: time goes from {t[k]:.9g} to {t[k + 1]:.9g} s "
            f"({wrong.size} such rows); expected it to rise; keep one run of the log, or give "
            "--sample-period if only the clock is coarse"
        )


def even_grid(table: LogTable, t: Array, signals: Mapping[str, Array]) -> Grid:
    """Return signals on an even grid.

    Parameters
    ----------
    table : for messages
    t : (n,) rising [s]
    signals : (n,) by role, nan where a value is missing

    Raises
    ------
    RecordingError
        When no stretch without gaps is long enough.
    """
    findings: list[Finding] = []
    steps = np.diff(t)
    if len(steps) < SHORTEST - 1:
        raise RecordingError(f"{table.path}: {len(t)} samples; expected at least {SHORTEST}")
    usual = float(np.median(steps))
    usual = float(np.mean(steps[steps < 1.5 * usual]))
    if not 1e-9 <= usual <= 1e4:
        raise RecordingError(
            f"{table.path}: a sample period of {usual:.3g} s; expected 1e-9 to 1e4 s, check the "
            "unit of the time"
        )
    if (wrong := np.flatnonzero(steps < 1e-6 * usual)).size:
        row, step = table.row(int(wrong[0]) + 1), steps[wrong[0]]
        raise RecordingError(
            f"{table.path}: row {row}: time moves by {step:.3g} s; expected about {usual:.3g} s"
        )
    begin, end = _longest(table, t, signals, usual, findings)
    t = t[begin:end]
    count = round((t[-1] - t[0]) / usual)
    T_s = (t[-1] - t[0]) / count
    grid = t[0] + np.arange(count + 1) * T_s
    off = np.abs((t - t[0]) / T_s - np.round((t - t[0]) / T_s))
    even = len(t) == len(grid) and float(np.max(off)) <= EVEN
    if not even and (jitter := float(np.sqrt(np.mean(off**2)))) > EVEN:
        figure = f"{jitter:.2g} of the sample period {T_s:.4g} s (rms)"
        advice = "if only the clock is coarse, give --sample-period"
        severity: Severity = "warning" if jitter > 0.1 else "note"
        findings.append(Finding(severity, "times are uneven", figure, advice))
    missing = len(grid) - len(t)
    result = {}
    methods: dict[str, list[str]] = {}
    for role, signal in signals.items():
        values = signal[begin:end]
        known = np.isfinite(values)
        if not known.all():
            first = table.row(begin + int(np.argmin(known)))
            figure = f"{np.sum(~known)}, the first in row {first}"
            findings.append(Finding("warning", f"{role}: numbers are missing", figure, "filled in"))
        if even and known.all():
            result[role] = values.copy()
            continue
        method = better_method(t[known], values[known])
        methods.setdefault(method, []).append(role)
        result[role] = interpolated(t[known], values[known], grid, method)
    if methods:
        how = "; ".join(f"{', '.join(names)} {method}" for method, names in methods.items())
        findings.append(
            Finding(
                "note", "interpolated between the logged samples", f"{missing} rows missing; {how}"
            )
        )
    return Grid(np.arange(count + 1) * T_s, result, findings)


def _longest(
    table: LogTable,
    t: Array,
    signals: Mapping[str, Array],
    usual: float,
    findings: list[Finding],
) -> tuple[int, int]:
    """Return the longest stretch (begin, end) without long gaps."""
    usable = np.ones(len(t), dtype=bool)
    for role, signal in signals.items():
        if not np.isfinite(signal).any():
            raise RecordingError(f"{table.path}: {role}: no finite number in the whole column")
        for begin, end in runs(~np.isfinite(signal)):
            if end - begin > FILLED or begin == 0 or end == len(t):
                usable[begin:end] = False
                where = f"rows {table.row(begin)} to {table.row(end - 1)}"
                findings.append(Finding("warning", f"{role} has no numbers in {where}"))
    breaks = np.flatnonzero(np.diff(t) > (FILLED + 1.5) * usual) + 1
    for k in breaks:
        gap = f"{t[k] - t[k - 1]:.3g} s before row {table.row(int(k))}"
        findings.append(Finding("warning", "a gap in time", gap))
    edges = np.unique(np.concatenate([[0], breaks, [len(t)]]))
    stretches = [
        (int(first) + begin, int(first) + end)
        for first, last in pairwise(edges)
        for begin, end in runs(usable[first:last])
    ]
    begin, end = max(stretches, key=lambda s: t[s[1] - 1] - t[s[0]], default=(0, 0))
    if end - begin < SHORTEST:
        raise RecordingError(
            f"{table.path}: the longest stretch without gaps has {end - begin} samples; expected "
            f"at least {SHORTEST}"
        )
    if end - begin < len(t):
        figure = f"{t[begin]:.6g} to {t[end - 1]:.6g} s, {(end - begin) / len(t):.1%} of the rows"
        rows = f"rows {table.row(begin)} to {table.row(end - 1)}"
        if len(findings) > 5:
            findings[4:] = [Finding("warning", f"{len(findings) - 4} more such gaps")]
        what = f"only {rows} are used, the longest stretch without gaps"
        findings.append(Finding("warning", what, figure))
    return begin, end


def runs(marked: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return (begin, end) of the runs of True in marks (n,)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marked, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def better_method(t: Array, signal: Array) -> Method:
    """Return the method that predicts every other sample from its neighbours better.

    A cubic spline, nearly band-limited, for smooth signals; straight lines for commands with
    corners and for signals that are mostly noise or steps.

    Parameters
    ----------
    t : (n,) rising [s]
    signal : (n,)
    """
    t, signal = t[:MOST], signal[:MOST]
    if len(t) < 9:
        return "linear"
    known, asked = slice(0, None, 2), slice(3, len(t) - 3, 2)
    errors = {
        method: np.sum(
            (interpolated(t[known], signal[known], t[asked], method) - signal[asked]) ** 2
        )
        for method in ("linear", "cubic")
    }
    return "cubic" if errors["cubic"] < errors["linear"] else "linear"


def interpolated(t: Array, signal: Array, at: Array, method: str) -> Array:
    """Return a signal (n,) given at t (n,) at other times (k,) [s]."""
    if method == "cubic":
        return np.asarray(scipy.interpolate.CubicSpline(t, signal)(at))
    return np.interp(at, t, signal)
