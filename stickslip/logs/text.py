"""Logs as text: CSV and its relatives."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from stickslip.errors import RecordingError
from stickslip.logs.dialect import (
    Dialect,
    commonest,
    find_dialect,
    split_unit,
    states_units,
    unbracketed,
)
from stickslip.logs.finding import Finding
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array

_SAMPLE = 200
MOST_BYTES = 1 << 28
MOST_LINES = 4_000_000
_BEGIN = 1 << 16
LONGEST = 1 << 17
"""Characters of a line."""
_BINARY = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")


_Line = tuple[int, str]
"""Number and text of a line."""


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
    body = [text for _, text in lines if _is_data(text)]
    if not body:
        raise RecordingError(f"{path}: no rows; expected columns of numbers")
    dialect = find_dialect(body, delimiter, decimal)
    header, units, numbered, rows = _split(lines, dialect)
    if not rows:
        raise RecordingError(f"{path}: no row of numbers; the last row is '{body[-1][:40]}'")
    width = len(header) or commonest(map(len, rows))
    findings = _check_widths(path, rows, width, numbered)
    if header and all(not row[-1] for row in rows) and not header[-1]:
        header, rows = header[:-1], [row[:-1] for row in rows]
    names = _names(header or [str(k + 1) for k in range(len(rows[0]))])
    numbers: dict[str, Array] = {}
    texts: dict[str, tuple[str, ...]] = {}
    faults: dict[str, str] = {}
    for name, column in zip(names, zip(*rows, strict=True), strict=True):
        values, wrong = _numbers(column, dialect)
        if 2 * len(wrong) > len(values):
            texts[name] = column
            continue
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
        {name: unit for name, unit in zip(names, units, strict=False) if unit},
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


def _lines(path: str, data: bytes) -> list[_Line]:
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


def _split(
    lines: Sequence[_Line], dialect: Dialect
) -> tuple[list[str], list[str | None], list[int], list[list[str]]]:
    """Return names and units of the header, and the rows of data with their numbers.

    The header is the last line without a number, of the right length, above the first that holds
    only numbers; text above it is left out.
    """
    width = commonest(len(dialect.fields(text)) for _, text in lines[-_SAMPLE:] if _is_data(text))
    above: list[int] = []
    head: list[list[str]] = []
    for _, text in lines:
        row = dialect.fields(text.lstrip("#% "))
        known = sum(dialect.number(field) is not None for field in row)
        if len(row) == width and 2 * known >= width:
            break
        if len(row) == width and not known:
            above.append(len(head))
        head.append(row)
    begin, names, units = len(head) if len(head) < len(lines) else 0, [], []
    if above:
        begin = above[-1] + 1
        last = head[above[-1]]
        if len(above) > 1 and above[-2] == above[-1] - 1 and states_units(last):
            names = [split_unit(field)[0] for field in head[above[-2]]]
            units = [unbracketed(field) or None for field in last]
        else:
            names, units = map(list, zip(*map(split_unit, last), strict=True))
    body = [(k, text) for k, text in lines[begin:] if _is_data(text)]
    return names, units, [k for k, _ in body], [dialect.fields(text) for _, text in body]


def _is_data(text: str) -> bool:
    return not text.startswith(("#", "%"))


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
