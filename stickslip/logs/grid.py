"""Resampling to an even grid: gaps filled or cut off, jitter removed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import RecordingError
from stickslip.logs.finding import Finding, Severity
from stickslip.logs.interpolation import better_method, interpolated
from stickslip.logs.jumps import continuous
from stickslip.logs.recording import Motion
from stickslip.logs.sampling import even_clock, mean_period
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array
from stickslip.thresholds import log_clock, log_content


@dataclass(frozen=True, eq=False)
class Grid:
    """Signals at even times."""

    t: Array  # (n,) from 0 on [s]
    signals: dict[str, Array]  # (n,) by role
    findings: list[Finding]  # what was done to get there


def even_grid(
    table: LogTable, t: Array, signals: Mapping[str, Array], motion: Motion = "linear"
) -> Grid:
    """Return signals on an even grid.

    Raises RecordingError when no stretch without gaps is long enough, or its times do not rise.

    Parameters
    ----------
    table : for messages
    t : (n,) that do not fall [s]
    signals : (n,) by role, nan where a value is missing
    motion : for messages
    """
    findings: list[Finding] = []
    if len(t) < log_content.FEWEST:
        least = f"{log_content.FEWEST:g}"
        raise RecordingError(f"{table.path}: {len(t)} samples; expected at least {least}")
    usual = mean_period(t)
    if not 1e-9 <= usual <= 1e4:
        raise RecordingError(
            f"{table.path}: a sample period of {usual:.3g} s; expected 1e-9 to 1e4 s, check the "
            "unit of the time"
        )
    begin, end = _longest(table, t, signals, usual, findings=findings)
    used = table.part(np.arange(begin, end))
    t = even_clock(used, t[begin:end], usual, findings)
    signals = {role: signal[begin:end] for role, signal in signals.items()}
    for role, signal in signals.items():
        if not (known := np.isfinite(signal)).all():
            figure = f"{np.sum(~known)}, the first in row {used.row(int(np.argmin(known)))}"
            findings.append(Finding("warning", f"{role}: numbers are missing", figure, "filled in"))
    signals = continuous(used, t, signals, motion, findings=findings)
    count = round((t[-1] - t[0]) / mean_period(t))
    T_s = (t[-1] - t[0]) / count
    grid = t[0] + np.arange(count + 1) * T_s
    off = np.abs((t - t[0]) / T_s - np.round((t - t[0]) / T_s))
    even = len(t) == len(grid) and float(np.max(off)) <= log_clock.EVEN
    if not even and (jitter := float(np.sqrt(np.mean(off**2)))) > log_clock.EVEN:
        figure = f"{jitter:.2g} of the sample period {T_s:.4g} s (rms)"
        advice = "if the samples are even and only the clock is not, give --sample-period"
        severity: Severity = "warning" if jitter > log_clock.UNEVEN else "note"
        findings.append(Finding(severity, "times are uneven", figure, advice))
    missing = len(grid) - len(t)
    result = {}
    methods: dict[str, list[str]] = {}
    for role, signal in signals.items():
        known = np.isfinite(signal)
        if even and known.all():
            result[role] = signal.copy()
            continue
        method = better_method(t[known], signal[known])
        methods.setdefault(method, []).append(role)
        result[role] = interpolated(t[known], signal[known], grid, method)
    if methods:
        how = "; ".join(f"{', '.join(names)} {method}" for method, names in methods.items())
        findings.append(
            Finding(
                "note", "interpolated between the logged samples", f"{missing} rows missing; {how}"
            )
        )
    return Grid(np.arange(count + 1) * T_s, result, findings)


def _longest(
    table: LogTable, t: Array, signals: Mapping[str, Array], usual: float, findings: list[Finding]
) -> tuple[int, int]:
    """Return the longest stretch (begin, end) without long gaps."""
    usable = np.ones(len(t), dtype=bool)
    for role, signal in signals.items():
        if not np.isfinite(signal).any():
            raise RecordingError(f"{table.path}: {role}: no finite number in the whole column")
        for begin, end in runs(~np.isfinite(signal)):
            if end - begin > log_clock.FILLED or begin == 0 or end == len(t):
                usable[begin:end] = False
                where = f"rows {table.row(begin)} to {table.row(end - 1)}"
                findings.append(Finding("warning", f"{role} has no numbers in {where}"))
    breaks = np.flatnonzero(np.diff(t) > (log_clock.FILLED + 1.5) * usual) + 1
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
    if end - begin < log_content.FEWEST:
        raise RecordingError(
            f"{table.path}: the longest stretch without gaps has {end - begin} samples; expected "
            f"at least {log_content.FEWEST:g}"
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
