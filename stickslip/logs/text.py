"""Logs as text: CSV and its relatives."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

import numpy as np

from stickslip.errors import RecordingError
from stickslip.logs.clock import clock_seconds, filetime_seconds, is_clock
from stickslip.logs.dialect import Dialect, find_dialect
from stickslip.logs.finding import Finding
from stickslip.logs.header import Header, Line, find_header, is_data
from stickslip.logs.signals import Signal, table_of
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array

MOST_BYTES = 1 << 28
MOST_LINES = 4_000_000
_BEGIN = 1 << 16
LONGEST = 1 << 17
"""Characters of a line."""
_BINARY = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")


def read_text(path: str, data: bytes, delimiter: str | None, decimal: str | None) -> LogTable:
    """Read a text file.

    Parameters
    ----------
    path : for messages
    data : content of the file
    delimiter, decimal : where known; detected otherwise

    Raises
    ------
    RecordingError
        When it is not text, holds no rows of numbers, or its rows differ in length.
    """
    lines = _lines(path, data)
    body = [text for _, text in lines if is_data(text)]
    if not body:
        raise RecordingError(f"{path}: no rows; expected columns of numbers")
    dialect = find_dialect(body, delimiter, decimal)
    head = find_header(lines, dialect)
    below = [line for line in lines[head.begin :] if is_data(line[1])]
    numbered, rows = [k for k, _ in below], [dialect.fields(text) for _, text in below]
    if not rows:
        raise RecordingError(f"{path}: no row of numbers; the last row is '{body[-1][:40]}'")
    header = head.names
    findings: tuple[Finding, ...] = ()
    if head.titled:
        rows = [[*row, *[""] * head.width][: head.width] for row in rows]
    else:
        findings = _check_widths(path, rows, len(header) or head.width, numbered)
    if header and all(not row[-1] for row in rows) and not header[-1]:
        header, rows = header[:-1], [row[:-1] for row in rows]
    if head.paired:
        return table_of(path, _pairs(path, head, rows, dialect), findings, timed=_timed(head))
    names = _names(header or [str(k + 1) for k in range(len(rows[0]))])
    units = {name: unit for name, unit in zip(names, head.units, strict=False) if unit}
    numbers: dict[str, Array] = {}
    texts: dict[str, tuple[str, ...]] = {}
    faults: dict[str, str] = {}
    for name, column in zip(names, zip(*rows, strict=True), strict=True):
        values, wrong = _numbers(column, dialect)
        if 2 * len(wrong) > len(values):
            texts[name] = column
            if is_clock(column[0]):
                units[name] = "s"
            continue
        if name == "time" and head.titled:
            values, units[name] = _scaled(values, column, head), "s"
        numbers[name] = values
        if wrong:
            shown = column[wrong[0]][:40]
            faults[name] = f"row {numbered[wrong[0]]}: expected a number, got '{shown}'"
    if not numbers:
        shown = " ".join(rows[0])[:40]
        raise RecordingError(f"{path}: row {numbered[0]}: expected numbers, got '{shown}'")
    return LogTable(
        path,
        names,
        numbers,
        texts,
        units,
        faults,
        rows=np.array(numbered[: len(rows)]),
        headed=bool(header),
        findings=findings,
    )


def is_text(data: bytes) -> bool:
    """Whether the begin of a file is text."""
    return not _BINARY.search(_decoded(data[:_BEGIN]))


def _decoded(data: bytes) -> str:
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return data.decode("utf-16", "replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _lines(path: str, data: bytes) -> list[Line]:
    """Return the lines that are not empty."""
    if len(data) > MOST_BYTES:
        raise RecordingError(f"{path}: {len(data)} bytes; at most {MOST_BYTES} are read as text")
    text = _decoded(data)
    if _BINARY.search(text):
        raise RecordingError(
            f"{path}: binary, not text, and of no known format; expected CSV or a file that "
            "ends in .parquet, .mat, .h5, .tdms, .mf4 or .xlsx"
        )
    numbered = enumerate(re.split(r"\r\n|\n|\r", text), start=1)
    lines = [(k, line.strip(" \r")) for k, line in numbered if line.strip()]
    if not lines:
        raise RecordingError(f"{path}: empty; expected columns of numbers")
    for k, line in lines:
        if len(line) > LONGEST or k > MOST_LINES:
            raise RecordingError(
                f"{path}: row {k}: {len(line)} characters; expected at most {LONGEST} characters "
                f"in a row and {MOST_LINES} rows"
            )
    return lines


def _check_widths(
    path: str, rows: list[list[str]], width: int, numbered: Sequence[int]
) -> tuple[Finding, ...]:
    """Remove a last row that is cut off; raise where another row has a wrong length."""
    k = next((k for k, row in enumerate(rows) if len(row) != width), None)
    if k is None:
        return ()
    if k == len(rows) - 1 and k > 0 and len(rows[k]) < width:
        del rows[k]
        what = f"row {numbered[k]}, the last, is cut off"
        return (Finding("warning", what, advice="it was left out"),)
    raise RecordingError(
        f"{path}: row {numbered[k]}: expected {width} fields as in the other rows, got "
        f"{len(rows[k])}"
    )


def _names(header: Sequence[str]) -> tuple[str, ...]:
    """Return distinct names: the number of the column for an empty one, appended to a repeated."""
    names: dict[str, None] = {}
    for k, text in enumerate(header):
        name = text or str(k + 1)
        while name in names:
            name = f"{name}_{k + 1}"
        names[name] = None
    return tuple(names)


def _numbers(column: Sequence[str], dialect: Dialect) -> tuple[Array, list[int]]:
    """Return a column as numbers, NaN for what is not one, and the places that are not empty."""
    try:
        fields = [f.replace(",", ".") for f in column] if dialect.decimal == "," else column
        return np.array(fields, dtype=np.float64), []
    except ValueError:
        values = [dialect.number(field) if field else np.nan for field in column]
        wrong = [k for k, value in enumerate(values) if value is None]
        return np.array(values, dtype=np.float64), wrong


def _pairs(
    path: str, head: Header, rows: Sequence[Sequence[str]], dialect: Dialect
) -> Iterator[Signal]:
    """Yield the signals of columns that take turns with those of their times."""
    for k in range(0, head.width - 1, 2):
        filled = [row for row in rows if row[k]]
        times, fields = [row[k] for row in filled], [row[k + 1] for row in filled]
        values, wrong = _numbers(fields, dialect)
        name, unit = head.names[k + 1], head.units[k + 1] or ""
        if not filled or len(wrong) > 0:
            instead = f"'{fields[wrong[0]][:40]}'" if filled else "nothing"
            yield Signal(name, None, unit, instead=instead)
            continue
        t, wrong = _numbers(times, dialect)
        if wrong and not is_clock(times[0]):
            raise RecordingError(f"{path}: times of '{name}': got '{times[wrong[0]][:40]}'")
        yield Signal(name, values, unit, _scaled(t, times, head, k))


def _timed(head: Header) -> str | None:
    """Return the unit of the times of signals, None where the file leaves it open."""
    return "s" if head.titled else head.units[0]


def _scaled(t: Array, texts: Sequence[str], head: Header, k: int = 0) -> Array:
    """Return times (n,) in s where the header has titled rows, else as they are.

    They are in ms, or in the unit that agrees with the sample period of the header.
    """
    if is_clock(texts[0]):
        return clock_seconds(texts)
    if (counted := filetime_seconds(texts)) is not None:
        return counted
    if not head.titled:
        return t
    period = next((period * 1e-3 for place, period in head.periods if place == k + 1), 0.0)
    usual = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if period <= 0 or usual <= 0:
        return t * 1e-3
    return t * min((1e-3, 1.0, 1e-6, 1e-7), key=lambda unit: abs(np.log(usual * unit / period)))
