"""Logs as text: CSV and its relatives.

A file is decoded line by line, and its fields become numbers block by block, so that time and
memory grow with its size, whatever it holds.
"""

import codecs
import io
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import RecordingError
from stickslip.logs.header import (
    LOOKED_AT,
    MISSING,
    SAMPLE,
    SAMPLED,
    Dialect,
    Header,
    Line,
    find_dialect,
    find_header,
    is_data,
)
from stickslip.logs.recording import Finding
from stickslip.logs.signals import Signal, table_of
from stickslip.logs.table import FILETIME, LogTable, clock_seconds, filetime_seconds, is_clock
from stickslip.servo.measurement import Array

MOST_BYTES = 1 << 30  # more than an hour of five columns at 2 kHz
MOST_LINES = 20_000_000
LONGEST = 1 << 17  # characters of a line
_BLOCK = 1 << 20  # characters of the lines that are texts at a time; their fields take about 40 MB
_BEGIN = 1 << 16
_BINARY = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
_UTF_16 = (codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)


@dataclass
class _Column:
    """A column as it is read."""

    parts: list[Array] = field(default_factory=list)  # its numbers, NaN for a field that holds none
    first: str = ""  # its first text
    # all its texts if the first is a point in time, else none
    texts: list[str] = field(default_factory=list)
    wrong: int = 0  # texts that are not numbers
    row: int = 0  # number of the row of the first of them
    got: str = ""  # its text

    @property
    def numbers(self) -> Array:
        """All numbers (n,)."""
        return np.concatenate(self.parts)

    def add(self, fields: Sequence[str], dialect: Dialect, rows: Sequence[int]) -> None:
        """Append the fields of some rows."""
        self.first = self.first or next(filter(None, fields), "")
        timed = is_clock(self.first)
        if timed or (self.first.isdecimal() and float(self.first) > FILETIME):
            self.texts += fields
        values, wrong = _numbers(fields, dialect, timed)
        if wrong and not self.wrong:
            self.row, self.got = rows[wrong[0]], fields[wrong[0]][:40]
        self.wrong += len(wrong)
        self.parts.append(values)


def read_text(path: str, data: bytes, delimiter: str | None, decimal: str | None) -> LogTable:
    """Read a text file with these data; delimiter and decimal sign are detected where not known.

    Raises RecordingError when it is not text, holds no rows of numbers, or its rows differ in
    length, or UsageError when delimiter and decimal sign are the same, and no quotes tell them
    apart. Messages name the path.
    """
    if len(data) > MOST_BYTES:
        raise RecordingError(f"{path}: {len(data)} bytes; at most {MOST_BYTES} are read as text")
    lines = _Lines(path, data)
    sample = [text for text in lines.sample() if is_data(text)]
    if not sample:
        raise RecordingError(f"{path}: empty, or comments only; expected columns of numbers")
    dialect = find_dialect(path, sample, delimiter, decimal)
    if not dialect.width:
        raise RecordingError(f"{path}: no row of numbers; the last row is '{sample[-1][:40]}'")
    head = find_header(lines, dialect)
    if not head.width:
        raise RecordingError(f"{path}: no row of numbers in its first {LOOKED_AT} lines")
    findings: list[Finding] = []
    columns, numbered = _columns(lines, dialect, head, findings)
    if not len(numbered):
        raise RecordingError(f"{path}: no row of numbers; the last row is '{sample[-1][:40]}'")
    header = head.names
    if header and not header[-1] and not columns[-1].first:  # a delimiter ends each line
        header, columns = header[:-1], columns[:-1]
    if head.paired:
        signals, timed = _pairs(path, head, columns), "s" if head.titled else head.units[0]
        return table_of(path, signals, tuple(findings), timed=timed)
    names = _names(header or [str(k + 1) for k in range(len(columns))])
    units = {name: unit for name, unit in zip(names, head.units, strict=False) if unit}
    numbers: dict[str, Array] = {}
    texts: dict[str, tuple[str, ...]] = {}
    faults: dict[str, str] = {}
    for name, column in zip(names, columns, strict=True):
        if 2 * column.wrong > len(numbered):
            texts[name] = tuple(column.texts) or (column.first,)
            if is_clock(column.first):
                units[name] = "s"
            continue
        numbers[name] = column.numbers
        if name == "time" and head.titled:
            numbers[name], units[name] = _scaled(numbers[name], column, head), "s"
        if column.wrong:
            faults[name] = f"row {column.row}: expected a number, got '{column.got}'"
    if not numbers:
        shown = " ".join(column.first for column in columns)[:40]
        raise RecordingError(f"{path}: row {numbered[0]}: expected numbers, got '{shown}'")
    return LogTable(
        path,
        names,
        numbers,
        texts,
        units=units,
        faults=faults,
        rows=numbered,
        headed=bool(header),
        findings=tuple(findings),
    )


def is_text(data: bytes) -> bool:
    """Whether the begin of a file is text."""
    return data.startswith(_UTF_16) or not _BINARY.search(data[:_BEGIN])


class _Lines:
    """The lines of a text that are not empty, and their numbers; raises RecordingError."""

    def __init__(self, path: str, data: bytes) -> None:
        self.path = path
        if data.startswith(_UTF_16):
            data = data.decode("utf-16", "replace").encode()
        elif _BINARY.search(data):
            raise RecordingError(
                f"{path}: binary, not text, and of no known format; expected CSV or a file that "
                "ends in .parquet, .mat, .h5, .tdms, .mf4 or .xlsx"
            )
        if b"\r" in data:
            data = data.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        if (count := data.count(b"\n")) > MOST_LINES:
            raise RecordingError(f"{path}: {count} lines; expected at most {MOST_LINES}")
        self.data = data
        decoder = codecs.getincrementaldecoder("utf-8")()
        try:
            for k in range(0, len(data), _BEGIN):
                decoder.decode(data[k : k + _BEGIN], k + _BEGIN >= len(data))
            self.encoding = "utf-8-sig"
        except UnicodeDecodeError:
            self.encoding = "latin-1"

    def sample(self) -> list[str]:
        """Return lines from all over the text, and its last ones."""
        data, found = self.data, []
        for k in range(SAMPLE):
            begin = data.rfind(b"\n", 0, k * len(data) // SAMPLE) + 1
            found.append(data[begin : begin + LONGEST].partition(b"\n")[0])
        found += data[-SAMPLED:].rstrip().split(b"\n")[-SAMPLE:]
        texts = [line.decode(self.encoding, "replace").strip(" ") for line in found]
        return [text for text in texts if text and not text.isspace()]

    def blocks(self) -> Iterator[tuple[int, list[str]]]:
        """Yield lines and the number of the first; raise RecordingError for one too long."""
        stream = io.TextIOWrapper(io.BytesIO(self.data), self.encoding, newline="\n")
        number = 1
        while block := stream.readlines(_BLOCK):
            if max(map(len, block)) > LONGEST + 1:
                k = next(k for k, line in enumerate(block) if len(line) > LONGEST + 1)
                raise RecordingError(
                    f"{self.path}: row {number + k}: {len(block[k]) - 1} characters; expected at "
                    f"most {LONGEST} in a row"
                )
            yield number, block
            number += len(block)

    def __iter__(self) -> Iterator[Line]:
        """Yield the lines that are not empty."""
        for number, block in self.blocks():
            for k, line in enumerate(block, start=number):
                if not line.isspace():
                    yield k, line.strip(" \n")


def _columns(
    lines: _Lines, dialect: Dialect, head: Header, findings: list[Finding]
) -> tuple[list[_Column], NDArray[np.intp]]:
    """Return the columns below a header, and numbers (n,) of their rows; raise RecordingError."""
    columns = [_Column() for _ in range(head.width)]
    numbered = [np.empty(0, dtype=np.intp)]
    wrong: dict[int, int] = {}
    for begin, block in lines.blocks():
        number = max(begin, head.begin)
        block = block[number - begin :]
        if block and not wrong and (values := _plain_numbers(block, dialect, head)) is not None:
            numbered.append(np.arange(number, number + len(block)))
            for column, part in zip(columns, values.T, strict=True):
                column.first = column.first or str(part[0])
                column.parts.append(part)
            continue
        places = [k for k, t in enumerate(block) if not t.isspace() and is_data(t.strip(" \n"))]
        rows = [dialect.fields(block[k].strip(" \n")) for k in places]
        if head.titled:
            rows = [[*row, *[""] * head.width][: head.width] for row in rows]
        places = [number + k for k in places]
        if {*map(len, rows)} - {head.width} or (wrong and rows):
            wrong |= {k: len(row) for k, row in zip(places, rows, strict=True)}
            wrong = {k: count for k, count in wrong.items() if count != head.width}
            if len(wrong) > 1 or places[-1] not in wrong:
                _raise_width(lines.path, head, wrong)
            del places[-1], rows[-1]
        if rows:
            numbered.append(np.array(places, dtype=np.intp))
            for column, fields in zip(columns, zip(*rows, strict=True), strict=True):
                column.add(fields, dialect, places)
    for k, count in wrong.items():
        if count > head.width or len(numbered) == 1:
            _raise_width(lines.path, head, wrong)
        what = f"row {k}, the last, is cut off"
        findings.append(Finding("warning", what, advice="it was left out"))
    return columns, np.concatenate(numbered)


def _raise_width(path: str, head: Header, wrong: Mapping[int, int]) -> NoReturn:
    """Raise the error of the first row whose number of fields differs."""
    row, count = next(iter(wrong.items()))
    raise RecordingError(
        f"{path}: row {row}: expected {head.width} fields as in the other rows, got {count}"
    )


def _plain_numbers(lines: Sequence[str], dialect: Dialect, head: Header) -> Array | None:
    """Return the numbers (n, width) of lines that hold nothing else, None for other lines."""
    if head.titled or head.paired or lines[0].isspace():
        return None
    if dialect.decimal == ",":
        lines = [line.replace(",", ".") for line in lines]
    delimiter = None if dialect.delimiter == " " else dialect.delimiter
    try:
        values = np.loadtxt(lines, delimiter=delimiter, comments=None, quotechar='"', ndmin=2)
    except ValueError:
        return None
    return values if values.shape == (len(lines), head.width) else None


def _names(header: Sequence[str]) -> tuple[str, ...]:
    """Return distinct names: the number of the column for an empty one, appended to a repeated."""
    names: dict[str, None] = {}
    for k, text in enumerate(header):
        name = text or str(k + 1)
        while name in names:
            name = f"{name}_{k + 1}"
        names[name] = None
    return tuple(names)


def _numbers(column: Sequence[str], dialect: Dialect, timed: bool) -> tuple[Array, list[int]]:
    """Return a column as numbers, NaN where it has none, and the places of other texts."""
    if timed:
        return np.full(len(column), np.nan), [k for k, field in enumerate(column) if field]
    try:
        fields = [f.replace(",", ".") for f in column] if dialect.decimal == "," else column
        return np.array(fields, dtype=np.float64), []
    except ValueError:
        known = {field: dialect.number(field) for field in set(column)}
        texts = {f for f, number in known.items() if number is None and f.lower() not in MISSING}
        wrong = [k for k, field in enumerate(column) if field in texts] if texts else []
        return np.array([known[field] for field in column], dtype=np.float64), wrong


def _pairs(path: str, head: Header, columns: Sequence[_Column]) -> Iterator[Signal]:
    """Yield the signals of columns that take turns with those of their times."""
    for k in range(0, head.width - 1, 2):
        times, values = columns[k : k + 2]
        name, unit = head.names[k + 1], head.units[k + 1] or ""
        if not times.first or values.wrong:
            yield Signal(name, None, unit, instead=f"'{values.got}'" if times.first else "nothing")
            continue
        if times.wrong and not is_clock(times.first):
            raise RecordingError(f"{path}: times of '{name}': got '{times.got}'")
        filled = np.array([*map(bool, times.texts)] or ~np.isnan(times.numbers))
        times.texts = [*filter(None, times.texts)]
        t = _scaled(times.numbers[filled], times, head, k)
        yield Signal(name, values.numbers[filled], unit, t)


def _scaled(t: Array, column: _Column, head: Header, k: int = 0) -> Array:
    """Return times (n,) in s: from ms, or the unit of the header's period, below titled rows."""
    if is_clock(column.first):
        return clock_seconds(column.texts)
    if (counted := filetime_seconds(column.texts)) is not None:
        return counted
    if not head.titled:
        return t
    period = next((period * 1e-3 for place, period in head.periods if place == k + 1), 0.0)
    usual = float(np.median(np.diff(t))) if len(t) > 1 else 0.0
    if period <= 0 or usual <= 0:
        return t * 1e-3
    return t * min((1e-3, 1.0, 1e-6, 1e-7), key=lambda unit: abs(np.log(usual * unit / period)))
