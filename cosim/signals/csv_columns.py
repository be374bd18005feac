"""Columns of numbers over time from untrusted CSV files."""

import csv
import io
from array import array
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import chain
from math import isfinite
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.cosim.errors import SignalError
from stickslip.fmi.files import read_limited
from stickslip.fmi.messages import printable, shown

Array = NDArray[np.float64]
MOST_BYTES = 1 << 28
LONGEST = 1 << 20  # characters of a line


def read_columns(path: Path) -> dict[str, Array]:
    """Return the columns (n,) of a CSV file by name, with ``time`` [s], which never falls."""
    label = str(path)
    try:
        text = read_limited(path, MOST_BYTES).decode("utf-8-sig")
        rows = csv.reader(_lines(text, label))
        names = [name.strip() for name in next(rows, [])]
        _check_names(names, label)
        first = next(filter(None, rows), [])
        widths = [max(1, len(cell.split())) for cell in first]
        columns = list(_elements(names, widths))
        _check_names(columns, label)
        numbers, place = array("d"), columns.index("time")
        before = -np.inf
        for row in chain([first] if first else [], rows):
            if not row:
                continue
            where = f"{label}, line {rows.line_num}"
            cells = row if len(columns) == len(names) else _split(row, names, widths, where)
            values = _numbers(cells, columns, where)
            if values[place] < before:
                what = f"time falls from {before} to {values[place]} s; sort the rows by time"
                raise SignalError(f"{where}: {what}")
            before = values[place]
            numbers.extend(values)
    except OSError as fault:
        raise SignalError(f"{label}: cannot be read: {fault.strerror}") from fault
    except (UnicodeDecodeError, csv.Error) as fault:
        raise SignalError(f"{label}: not a CSV file in UTF-8: {fault}") from fault
    if not numbers:
        raise SignalError(f"{label}: no values below the first line")
    table = np.array(numbers).reshape(-1, len(columns))
    return dict(zip(columns, table.T, strict=True))


def _elements(names: Sequence[str], widths: Sequence[int]) -> Iterator[str]:
    """Yield a name for each number of a row: of a cell with several, name[1], name[2], ..."""
    for name, width in zip(names, [*widths, *[1] * len(names)], strict=False):
        yield from (name,) if width == 1 else (f"{name}[{k}]" for k in range(1, width + 1))


def _split(row: list[str], names: Sequence[str], widths: Sequence[int], place: str) -> list[str]:
    """Return the numbers of a row whose cells hold arrays, row by row, as FMI writes them."""
    cells = [cell.split() or [cell] for cell in row]
    for name, cell, width in zip(names, cells, widths, strict=False):
        if len(cell) != width:
            what = f"expected {width} numbers as in the first row, got {len(cell)}"
            raise SignalError(f"{place}: column {shown(name)}: {what}")
    return [number for cell in cells for number in cell]


def _lines(text: str, label: str) -> Iterator[str]:
    """Yield lines, each ended by LF, CR or both; none may be without end."""
    for number, line in enumerate(io.StringIO(text, newline=""), start=1):
        if len(line) > LONGEST:
            what = f"{len(line)} characters, expected at most {LONGEST}"
            raise SignalError(f"{label}, line {number}: {what}")
        yield line


def _check_names(names: Sequence[str], label: str) -> None:
    twice = [name for name, n in Counter(names).items() if n > 1]
    if "time" not in names or twice:
        got = f"{shown(twice[0])} twice" if twice else printable(repr(", ".join(names)))
        what = "a first line of distinct names, 'time' among them, separated by commas"
        raise SignalError(f"{label}: expected {what}, got {got}")


def _numbers(row: Sequence[str], names: Sequence[str], place: str) -> list[float]:
    if len(row) != len(names):
        raise SignalError(f"{place}: expected {len(names)} cells, got {len(row)}")
    try:
        values = list(map(float, row))
    except ValueError:
        values = []
    if not (values and all(map(isfinite, values)) and "_" not in "".join(row)):
        wrong = next(k for k, cell in enumerate(row) if not _is_finite(cell))
        what = f"expected a finite number, got {shown(row[wrong])}"
        raise SignalError(f"{place}: column {shown(names[wrong])}: {what}")
    return values


def _is_finite(cell: str) -> bool:
    try:
        return isfinite(float(cell)) and "_" not in cell  # which Python alone allows
    except ValueError:
        return False
