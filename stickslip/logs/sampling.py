"""When the rows of a log were sampled: repeated rows, rounded clocks, channels with own times."""

from collections.abc import Mapping
from typing import Literal

import numpy as np
import scipy
from numpy.typing import NDArray

from stickslip.errors import RecordingError
from stickslip.logs.recording import Finding
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array
from stickslip.thresholds import log_clock

DIVISORS = 12  # most encoder steps that the smallest difference of a signal may have
SHARE = 0.98  # share of the differences that must be whole steps


def step_of(signal: Array) -> float:
    """Return the step of which all differences of a signal (n,) are multiples; 0 if there is none.

    Differences within the rounding of doubles at the size of the signal are ignored. A filtered
    signal, or one with all its digits, has no step, and one that only rises evenly shows none.
    """
    signed = np.diff(signal[np.isfinite(signal)])
    differences = np.abs(signed)
    if not len(differences):
        return 0.0
    floor = 256 * np.finfo(float).eps * float(np.max(np.abs(signal[np.isfinite(signal)])))
    differences = np.sort(differences[differences > floor])
    if len(differences) < 10:
        return 0.0
    smallest = float(differences[len(differences) // 100])
    near = differences[differences < 1.02 * smallest]
    for divisor in range(1, DIVISORS + 1):
        step = _refined(differences, float(np.median(near)) / divisor)
        counts = differences / step
        whole = np.abs(counts - np.round(counts)) < 0.05 + floor / step
        if step > 4 * floor and np.mean(whole & (counts > 0.5)) >= SHARE:
            usual = np.round(np.median(signed) / step)
            even = usual != 0.0 and np.mean(np.round(signed / step) == usual) >= SHARE
            return 0.0 if even else step
    return 0.0


def _refined(differences: Array, step: float) -> float:
    """Return a step fitted to larger and larger differences."""
    for most in (3, 30, 300):
        counts = np.round(differences / step)
        some = (counts > 0) & (counts <= most)
        if some.any():
            step = float(differences[some] @ counts[some] / (counts[some] @ counts[some]))
    return step


def clock_step(t: Array) -> float:
    """Return the step of which all differences of times (n,) are multiples; 0 if there is none."""
    single = t.astype(np.float32)
    spacing = np.spacing(np.abs(single)).astype(np.float64)
    least = float(spacing.max()) if np.all(np.abs(t - single) < 0.05 * spacing) else 0.0
    floor = 8 * np.finfo(float).eps * float(np.max(np.abs(t)))
    differences = np.unique(np.abs(np.diff(t)))
    differences = differences[differences > floor]
    step = float(differences.min(initial=np.inf))
    while 100.0 * floor < step < np.inf:  # Euclid's algorithm
        rest = np.abs(differences - step * np.round(differences / step))
        rest = rest[rest > floor * (1.0 + differences / step)]
        if not rest.size:
            return max(step, least)
        step = float(rest.min())
    return least


MOST = 20_000  # number of samples on which the choice of an interpolation is based

Method = Literal["linear", "cubic"]


def better_method(t: Array, signal: Array) -> Method:
    """Return the method that predicts every other sample from its neighbours better.

    A cubic spline, nearly band-limited, for smooth signals; straight lines for commands with
    corners and for signals that are mostly noise or steps. The times t (n,) rise [s].
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


SPAN = 16  # rows over which a period is averaged: it divides rounding, and few rows are lost
FOLLOWED = 4096  # most rows to which the period of a clock that drifts is fitted


def mean_period(t: Array) -> float:
    """Return the usual time from one row to the next, of times (n,) that may be rounded [s]."""
    spans = t[SPAN:] - t[:-SPAN]
    usual = float(np.median(spans))
    near = spans[np.abs(spans - usual) < 0.75 * usual / SPAN]
    return float(np.mean(near if near.size else usual)) / SPAN


def regular_times(t: Array, period: float) -> Array | None:
    """Return the times (n,) of a regular clock whose rounding gives others, None if there is none.

    Rows may be missing where the clock's step is less than the period. The clock may drift slowly.
    The times t (n,) do not fall, and the period is about that of the clock [s].
    """
    step = clock_step(t)
    if not step:
        return None
    for numbers in (_counted(t, period), np.arange(len(t))):
        if np.all(np.diff(numbers) > 0):
            for degree in (1, 3):
                fit = np.polynomial.Polynomial.fit(numbers, t, degree)
                if np.ptp(t - fit(numbers)) <= log_clock.ROUNDED * step:
                    return np.asarray(fit(numbers))
    return None


def _counted(t: Array, period: float) -> NDArray[np.intp]:
    """Return the numbers (n,) of rows on a clock, whose period is refined along the way."""
    begin, slope, done = float(t[0]), period, 0
    numbers = np.zeros(len(t), dtype=np.intp)
    while done < len(t) and slope > 0:
        end = done + min(max(SPAN, done // 8), FOLLOWED // 8)
        numbers[done:end] = np.round((t[done:end] - begin) / slope)
        recent, done = slice(max(0, end - FOLLOWED), end), end
        if np.ptp(numbers[recent]):
            slope, begin = np.polyfit(numbers[recent], t[recent], 1)
    return numbers


def without_repeats(
    table: LogTable, t: Array, signals: Mapping[str, Array], findings: list[Finding]
) -> NDArray[np.intp]:
    """Return the rows (k,) of a log that are not copies of others, if time rises without them.

    A rounded clock gives rows with equal times, too, and those at rest may be alike. Raises
    RecordingError when time falls, or a time is not finite; names the row.
    """
    if (wrong := np.flatnonzero(~np.isfinite(t))).size:
        row = table.row(int(wrong[0]))
        raise RecordingError(f"{table.path}: row {row}: expected a time, got {t[wrong[0]]}")
    rows = _once(table, t, signals, findings)
    if (falls := np.flatnonzero(np.diff(t[rows]) < 0)).size:
        k = int(falls[0])
        raise RecordingError(
            f"{table.path}: row {table.row(k + 1)}: time goes from {t[k]:.9g} to {t[k + 1]:.9g} s "
            f"({falls.size} such rows); expected it to rise; cut the file there and give each "
            "part as a log"
        )
    if np.any(np.diff(t[rows]) <= 0):
        _check_instants(table, t, signals)
    return rows


def _once(
    table: LogTable, t: Array, signals: Mapping[str, Array], findings: list[Finding]
) -> NDArray[np.intp]:
    """Return the rows (k,) without copies of others if time rises among these, else all."""
    rows = np.arange(len(t))
    if np.all(np.diff(t) > 0):
        return rows
    values = np.column_stack([t, *signals.values()])
    values[np.isnan(values)] = np.inf  # equal to each other
    once = np.sort(np.unique(values, axis=0, return_index=True)[1])
    if not np.all(np.diff(t[once]) > 0):
        return rows
    copies = np.setdiff1d(rows, once)
    figure = f"{len(copies)}, the first is row {table.row(int(copies[0]))}"
    what = "rows with the same time and the same values as another are dropped"
    findings.append(Finding("warning", what, figure))
    return once


def even_rows(
    table: LogTable, t: Array, signals: Mapping[str, Array], findings: list[Finding]
) -> NDArray[np.intp]:
    """Return the rows (k,) of a log whose samples are even, whatever its column of time says."""
    if own := _in_turn(signals):
        raise RecordingError(
            f"{table.path}: {own} has numbers and blanks in turn; its samples have the times of "
            "their rows; read it without <sample_period>"
        )
    return _once(table, t, signals, findings)


def _in_turn(signals: Mapping[str, Array]) -> str:
    """Return the role of a channel whose numbers and blanks alternate; empty if there is none."""
    known = {role: np.isfinite(signal) for role, signal in signals.items()}
    for role, one in known.items():
        if np.sum(one[:-1] & ~one[1:]) > log_clock.IN_TURN * np.sum(one):
            return role
    return ""


def _check_instants(table: LogTable, t: Array, signals: Mapping[str, Array]) -> None:
    """Raise RecordingError where the drive does not move between rows of equal times."""
    steps = np.abs(np.diff(signals.get("position", t)))
    equal = np.flatnonzero(np.diff(t)[1:-1] == 0) + 1
    beside = np.nansum(steps[equal - 1] + steps[equal + 1]) / 2
    if np.nansum(steps[equal]) < log_clock.STILL * beside:
        raise RecordingError(
            f"{table.path}: row {table.row(int(equal[0]) + 1)}: the same time and position as in "
            f"the row before, but other values ({equal.size} such rows); expected one row per "
            "sample; log one source only"
        )


def even_clock(table: LogTable, t: Array, period: float, findings: list[Finding]) -> Array:
    """Return times (n,) that rise: those of a regular clock if their rounding explains others.

    Raises RecordingError when times are equal and no regular clock explains it; names the row.
    """
    found = regular_times(t, period)
    if found is not None:
        if float(np.max(np.abs(found - t))) <= log_clock.EVEN * period:
            return t
        figure = f"a row each {mean_period(found):.6g} s, in steps of {clock_step(t):.4g} s"
        findings.append(Finding("note", "times are those of a regular clock, rounded", figure))
        return found
    if (equal := np.flatnonzero(np.diff(t) < 1e-6 * period)).size:
        row, step = table.row(int(equal[0]) + 1), t[equal[0] + 1] - t[equal[0]]
        raise RecordingError(
            f"{table.path}: row {row}: time moves by {step:.3g} s ({equal.size} such rows), but "
            f"the values differ; expected about {period:.3g} s, and no regular clock explains the "
            "times; log the time of each row with more digits"
        )
    return t


def on_one_clock(
    table: LogTable, t: Array, signals: dict[str, Array], findings: list[Finding]
) -> tuple[NDArray[np.intp], Array, dict[str, Array]]:
    """Return rows (k,) of a log, their times (k,) and signals (k,) at these.

    A channel whose numbers and blanks alternate was sampled at times of its own. It is interpolated
    to those of the position, or else of the velocity: one that is interpolated between its samples
    shows false accelerations. Raises RecordingError when a channel was sampled too slowly for that.
    """
    if not _in_turn(signals):
        rows = without_repeats(table, t, signals, findings)
        return rows, t[rows], {role: signal[rows] for role, signal in signals.items()}
    own = {}
    for role, signal in signals.items():
        rows = np.flatnonzero(np.isfinite(signal))
        rows = rows[
            without_repeats(table.part(rows), t[rows], {role: signals[role][rows]}, findings)
        ]
        if len(rows) <= SPAN:
            raise RecordingError(f"{table.path}: {role}: {len(rows)} numbers in the whole column")
        period = mean_period(t[rows])
        own[role] = rows, even_clock(table.part(rows), t[rows], period, findings), period
    base = "position" if "position" in own else "velocity"
    rows, times, fastest = own[base]
    result, moved = {base: signals[base][rows]}, []
    for role, (mine, at, period) in own.items():
        if period > (log_clock.FILLED + 1) * fastest:
            raise RecordingError(
                f"{table.path}: {role} was sampled each {period:.4g} s, and the {base} each "
                f"{fastest:.4g} s; expected at most {log_clock.FILLED + 1:g} times less often; log "
                f"it faster, or leave it out with <column {role}=none>"
            )
        if len(mine) == len(rows) and np.array_equal(at, times):
            result[role] = signals[role][mine]
            continue
        method = better_method(at, signals[role][mine])
        after = np.clip(np.searchsorted(at, times), 1, len(at) - 1)
        far = at[after] - at[after - 1] > (log_clock.FILLED + 1.5) * period
        far |= (times < at[0]) | (times > at[-1])
        drawn = interpolated(at, signals[role][mine], times, method)
        result[role] = np.where(far, np.nan, drawn)
        moved.append(f"{role} (each {period:.4g} s, {method})")
    what = "rows that hold one channel each are joined by their times"
    if moved:
        what = f"channels that were sampled at other times are interpolated to those of the {base}"
    findings.append(Finding("note", what, ", ".join(moved)))
    return rows, times, result
