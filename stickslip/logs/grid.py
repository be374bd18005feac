"""Resampling to an even grid: gaps filled or cut off, jitter removed."""

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.errors import RecordingError
from stickslip.fmi.messages import quantity
from stickslip.logs.recording import Finding, Motion, Severity
from stickslip.logs.sampling import better_method, even_clock, interpolated, mean_period, step_of
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array
from stickslip.thresholds import log_clock, log_content, log_jump

AROUND = 17  # steps around one, with itself
WORDS = tuple(2.0**n for n in range(8, 33))  # counts after which a counter restarts


def jumps(t: Array, x: Array) -> tuple[NDArray[np.intp], Array, Array]:
    """Return after which samples (k,) a signal jumps, how far, and the tolerance of that (k,)."""
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
            findings.append(_jumped(table, t, signals[role], known[at], sizes=sizes, unit=per))
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
    close = (d for d in range(1, 17) if abs(float(f"{size:.{d}g}") - size) <= slack / 100)
    digits = next(close, 17)  # which give any size exactly
    return float(f"{size:.{digits}g}")


def _unwrap(role: str, size: float, signals: dict[str, Array]) -> tuple[int, int]:
    """Count a signal on, and a position's command; return how often it restarts, and where."""
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


def _jumped(
    table: LogTable, t: Array, x: Array, at: NDArray[np.intp], sizes: Array, unit: str
) -> Finding:
    """Return the error of a position (n,) that jumps, with the longest part that does not."""
    first = int(np.argmax(np.abs(sizes)))
    figure = f"by {quantity(float(sizes[first]), unit, 4)} in row {table.row(int(at[first]) + 1)}"
    if at.size > 1:
        figure += f", and {at.size - 1} times more"
    begin, end = 0, len(t)
    while at.size:
        edges = np.concatenate([[begin], at + 1, [end]])
        k = int(np.argmax(np.diff(edges)))
        begin, end = edges[k] + 2, edges[k + 1] - 2
        known = begin + np.flatnonzero(np.isfinite(x[begin:end]))
        at = known[jumps(t[known], x[known])[0]] if len(known) > log_content.FEWEST else at[:0]
    span = t[[begin, end - 1]]
    advice = f"cut the log there; <span {span[0]:.9g} {span[1]:.9g}> is its longest part"
    return Finding("error", "the position jumps, as no drive can", figure, advice)


def even_grid(
    table: LogTable, t: Array, signals: Mapping[str, Array], motion: Motion = "linear"
) -> tuple[Array, dict[str, Array], list[Finding]]:
    """Return even times (k,) from 0 on [s], signals (k,) by role at these, and what was done.

    They are given at times t (n,) that do not fall [s], NaN where a value is missing; table and
    motion are for messages. Raises RecordingError when no stretch without gaps is long enough, or
    its times do not rise.
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
        advice = "if the samples are even and only the clock is not, give <sample_period>"
        severity: Severity = "warning" if jitter > log_clock.UNEVEN else "note"
        findings.append(Finding(severity, "times are uneven", figure, advice))
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
        how = [f"{', '.join(names)} {method}" for method, names in methods.items()]
        missing = [f"{len(grid) - len(t)} rows missing"] if len(grid) > len(t) else []
        figure = "; ".join([*missing, *how])
        findings.append(Finding("note", "interpolated between the logged samples", figure))
    return np.arange(count + 1) * T_s, result, findings


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
