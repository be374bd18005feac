"""Logs as text: CSV and its relatives."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

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

_COMMENT = ("#", "%")
_SAMPLE = 200
MOST_BYTES = 1 << 28
MOST_LINES = 4_000_000
LONGEST = 1 << 17
"""Characters of a line."""
_BINARY = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")


@dataclass(frozen=True)
class _Line:
    number: int
    text: str


def read_text(path: str, data: bytes, delimiter: str | None, decimal: str | None) -> LogTable:
    """Read a text file.

    Parameters
    ----------
    path : for messages
    data : what the file holds
    delimiter, decimal : where known; else found out

    Raises
    ------
    RecordingError
        When it is no text, holds no rows of numbers, or its rows differ in length.
    """
    lines = _lines(path, data)
    body = [line for line in lines if not line.text.startswith(_COMMENT)]
    if not body:
        raise RecordingError(f"{path}: no rows; expected columns of numbers")
    dialect = find_dialect([line.text for line in body], delimiter, decimal)
    last = body[-1]
    header, units, body = _split(lines, dialect)
    if not body:
        raise RecordingError(
            f"{path}: no row of numbers; the last, row {last.number}, is '{last.text[:40]}'"
        )
    numbered = [line.number for line in body]
    if (numbers := _quickly(body, dialect, len(header))) is not None:
        names = _names(header or [str(k + 1) for k in range(numbers.shape[1])])
        columns = dict(zip(names, numbers.T.copy(), strict=True))
        stated = {n: unit for n, unit in zip(names, units, strict=False) if unit}
        return LogTable(
            path, names, columns, units=stated, rows=np.array(numbered), headed=bool(header)
        )
    rows = [dialect.fields(line.text) for line in body]
    width = len(header) or commonest(map(len, rows))
    findings = _check_widths(path, rows, width, numbered, headed=bool(header))
    if header and all(not row[-1] for row in rows) and not header[-1]:
        header, units, rows = header[:-1], units[:-1], [row[:-1] for row in rows]
    names = _names(header or [str(k + 1) for k in range(len(rows[0]))])
    columns = {
        name: _Column.of(column, dialect, numbered)
        for name, column in zip(names, zip(*rows, strict=True), strict=True)
    }
    if all(column.numbers is None for column in columns.values()):
        shown = body[0].text[:40]
        raise RecordingError(f"{path}: row {numbered[0]}: expected numbers, got '{shown}'")
    return LogTable(
        path,
        names,
        {name: c.numbers for name, c in columns.items() if c.numbers is not None},
        {name: c.texts for name, c in columns.items() if c.texts is not None},
        {name: unit for name, unit in zip(names, units, strict=True) if unit} if units else {},
        {name: c.fault for name, c in columns.items() if c.fault},
        rows=np.array(numbered[: len(rows)]),
        headed=bool(header),
        findings=findings,
    )


def _lines(path: str, data: bytes) -> list[_Line]:
    """Return the lines that are not empty."""
    if len(data) > MOST_BYTES:
        raise RecordingError(f"{path}: {len(data)} bytes; at most {MOST_BYTES} are read as text")
    try:
        if data.startswith((b"\xff\xfe", b"\xfe\xff")):
            text = data.decode("utf-16")
        else:
            text = data.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = data.decode("latin-1")
    if _BINARY.search(text):
        raise RecordingError(
            f"{path}: binary, not text; expected CSV, Parquet (.parquet) or MATLAB (.mat)"
        )
    if text.count("\n") + text.count("\r") > MOST_LINES:
        raise RecordingError(f"{path}: more than {MOST_LINES} lines; take a part of the log")
    lines = [
        _Line(k, line.strip(" \r"))
        for k, line in enumerate(re.split(r"\r\n|\n|\r", text), start=1)
        if line.strip()
    ]
    if not lines:
        raise RecordingError(f"{path}: empty; expected columns of numbers")
    for line in lines:
        if len(line.text) > LONGEST:
            raise RecordingError(
                f"{path}: row {line.number}: {len(line.text)} characters; expected at most "
                f"{LONGEST} in a row"
            )
    return lines


def _split(
    lines: Sequence[_Line], dialect: Dialect
) -> tuple[list[str], list[str | None], list[_Line]]:
    """Return header, units and the lines of data.

    The header is the last line without a number, of the right length, above the first that holds
    only numbers; text above it tells of the log and is left out.
    """
    data = [dialect.fields(line.text) for line in lines[-_SAMPLE:] if _is_data(line)]
    width = commonest(map(len, data))
    above: list[int] = []
    rows: list[list[str]] = []
    for line in lines:
        row = dialect.fields(line.text.lstrip("#% "))
        if len(row) == width and _numeric(row, dialect):
            break
        if len(row) == width and all(dialect.number(field) is None for field in row):
            above.append(len(rows))
        rows.append(row)
    if above:
        begin = above[-1] + 1
        if len(above) > 1 and above[-2] == above[-1] - 1 and states_units(rows[above[-1]]):
            header = rows[above[-2]]
            units = [unbracketed(field) or None for field in rows[above[-1]]]
            names = [split_unit(field)[0] for field in header]
        else:
            pairs = [split_unit(field) for field in rows[above[-1]]]
            names, units = [name for name, _ in pairs], [unit for _, unit in pairs]
    else:
        begin, names, units = (len(rows) if len(rows) < len(lines) else 0), [], []
    return names, units, [line for line in lines[begin:] if _is_data(line)]


def _quickly(body: Sequence[_Line], dialect: Dialect, width: int) -> Array | None:
    """Return the numbers (n, width) of a file without any fault, None of another."""
    texts = [line.text for line in body]
    if dialect.delimiter != " " and len({text.count(dialect.delimiter) for text in texts}) > 1:
        return None
    if dialect.decimal == ",":
        texts = [text.replace(",", ".") for text in texts]
    delimiter = None if dialect.delimiter == " " else dialect.delimiter
    try:
        numbers = np.loadtxt(texts, delimiter=delimiter, ndmin=2, comments=None)
    except ValueError:
        return None
    return numbers if width in (0, numbers.shape[1]) else None


def _is_data(line: _Line) -> bool:
    return not line.text.startswith(_COMMENT)


def _numeric(row: Sequence[str], dialect: Dialect) -> bool:
    """Whether at least half of the fields are numbers."""
    return 2 * sum(dialect.number(field) is not None for field in row) >= len(row)


def _check_widths(
    path: str, rows: list[list[str]], width: int, numbered: Sequence[int], *, headed: bool
) -> tuple[Finding, ...]:
    """Take away a last row that was cut off; complain of other rows of a wrong length."""
    wrong = [k for k, row in enumerate(rows) if len(row) != width]
    if not wrong:
        return ()
    k = wrong[0]
    if k == len(rows) - 1 and k > 0 and len(rows[k]) < width:
        del rows[k]
        what = f"row {numbered[k]}, the last, is cut off"
        return (Finding("warning", what, advice="it was left out"),)
    like = "as the header has" if headed else "as most rows have"
    raise RecordingError(
        f"{path}: row {numbered[k]}: expected {width} fields {like}, got {len(rows[k])}"
    )


def _names(header: Sequence[str]) -> tuple[str, ...]:
    """Return names that differ: a number for one without, a number behind one that came before."""
    names: dict[str, None] = {}
    for k, text in enumerate(header):
        name = text or str(k + 1)
        while name in names:
            name = f"{name}_{k + 1}"
        names[name] = None
    return tuple(names)


@dataclass(frozen=True)
class _Column:
    numbers: Array | None = None
    texts: tuple[str, ...] | None = None
    fault: str | None = None

    @classmethod
    def of(cls, column: tuple[str, ...], dialect: Dialect, numbered: Sequence[int]) -> _Column:
        """Turn fields into numbers; most must be, else the column is text."""
        try:
            fields = [f.replace(",", ".") for f in column] if dialect.decimal == "," else column
            return cls(np.array(fields, dtype=np.float64))
        except ValueError:
            pass
        values = [dialect.number(field) if field else np.nan for field in column]
        wrong = [k for k, value in enumerate(values) if value is None]
        if 2 * len(wrong) > len(values):
            return cls(texts=column)
        numbers = np.array([np.nan if value is None else value for value in values])
        if not wrong:
            return cls(numbers)
        k = wrong[0]
        fault = f"row {numbered[k]}: expected a number, got '{column[k][:40]}'"
        return cls(numbers, fault=fault)
