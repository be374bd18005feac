"""Tables of inputs from files and data frames, and results into files."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stickslip.cosim.errors import CosimError, SignalError
from stickslip.cosim.signals.signals import Array, Input, Table
from stickslip.fmi.by_name import by_name
from stickslip.fmi.files import atomic_write, read_limited
from stickslip.fmi.messages import installing, printable, shown

if TYPE_CHECKING:
    import pandas as pd


Inputs: TypeAlias = "Mapping[str, Input] | pd.DataFrame"
"""Signals by input, or a data frame with a column of each over time [s]."""
_SHEET = (1_048_576, 16_384)  # rows and columns of a sheet of Excel


def read_tables(
    source: pd.DataFrame | str | os.PathLike[str], held: bool | Collection[str] = False
) -> dict[str, Table]:
    """Return the signals of a table by column.

    Parameters
    ----------
    source : a data frame, or a file ``.csv`` or ``.parquet``, with a column ``time`` (s) that never
        falls; a time that occurs twice makes a jump. A cell of a ``.csv`` with several numbers,
        such as ``1 2 3``, holds an array row by row: the columns name[1], name[2], name[3]. The
        time may be the index of a frame, also as differences of time
    held : the columns whose values hold until the next time; the others are linear in between

    Raises
    ------
    SignalError : when the file cannot be read, or contains a value that is not a number
    """
    tables = _read(source)
    names = {name: {name, name.partition("[")[0]} for name in tables}  # also of a cell's array
    steps = tables.keys() if held is True else set(held or ())
    if unknown := sorted(set(steps).difference(*names.values())):
        raise SignalError(f"cannot hold {', '.join(unknown)}: there is no such column")
    return {
        name: Table(table.time, table.values, held=not names[name].isdisjoint(steps))
        for name, table in tables.items()
    }


def write_parquet(path: Path, frame: pd.DataFrame, units: Mapping[str, str | None]) -> None:
    """Write a frame, its index as the first column; units go into the metadata of the columns."""
    arrow = _arrow(CosimError, path)
    table = arrow.Table.from_pandas(frame.reset_index(), preserve_index=False)
    known = {frame.index.name: "s"} | dict(units)
    fields = [
        field.with_metadata({"unit": known[field.name] or ""} if known.get(field.name) else None)
        for field in table.schema
    ]
    table = table.cast(arrow.schema(fields, table.schema.metadata))
    import pyarrow.parquet  # a module of its own

    stream = io.BytesIO()
    pyarrow.parquet.write_table(table, stream)
    atomic_write(path, stream.getvalue())


def write_excel(path: Path, frame: pd.DataFrame) -> None:
    """Write a frame, its index as the first column, into the sheet of a workbook."""
    if len(frame) >= _SHEET[0] or len(frame.columns) >= _SHEET[1]:
        raise CosimError(
            f"{path}: a sheet of Excel has {_SHEET[0]} rows and {_SHEET[1]} columns, the result"
            f" {len(frame) + 1} and {len(frame.columns) + 1}; record less, or write .csv"
        )
    stream = io.BytesIO()
    try:
        frame.to_excel(stream, engine="openpyxl")
    except ImportError:
        advice = f"install it with {installing('excel')}"
        raise CosimError(f"{path}: Excel files need openpyxl; {advice}") from None
    atomic_write(path, stream.getvalue())


def _read(source: pd.DataFrame | str | os.PathLike[str]) -> dict[str, Table]:
    import pandas as pd  # late, for those who start quickly

    if isinstance(source, pd.DataFrame):
        return _from_frame(source, "the data frame")
    path = Path(source)
    if path.suffix in (".xls", ".xlsx"):
        raise SignalError(f"{path}: expected a table .csv or .parquet; save it as one of these")
    if path.suffix != ".parquet":
        return Table.all_from_csv(path)
    _arrow(SignalError, path)
    try:
        columns = read_parquet(read_limited(path, MOST_BYTES))
    except OSError as fault:
        raise SignalError(f"{path}: cannot be read: {fault.strerror}") from fault
    except Unreadable as fault:
        raise SignalError(f"{path}: cannot be read: {fault}") from None
    for name, column in columns.items():
        if column.numbers is None or column.unit:
            what = f"expected numbers, got {printable(column.kind)}"
            raise SignalError(f"{path}: column {shown(name)}: {what}")
    return _from_frame(pd.DataFrame({n: c.numbers for n, c in columns.items()}), str(path))


def signals_of(inputs: Inputs | None) -> dict[str, Input]:
    """Return signals by input, of pandas as tables; SignalError where an index is not times."""
    if not isinstance(inputs, Mapping | None) and hasattr(inputs, "columns"):
        return dict(_from_frame(inputs, "the data frame"))
    also = ", such as read_tables returns of a file, or a data frame"
    given = by_name("inputs", inputs, SignalError, also)
    return {name: _from_series(name, signal) for name, signal in given.items()}


def _from_series(name: str, signal: Input | pd.Series) -> Input:
    if not (hasattr(signal, "index") and hasattr(signal, "to_frame")):
        return signal
    return _from_frame(signal.to_frame("values"), f"the series of input {name!r}")["values"]


def _from_frame(frame: pd.DataFrame, label: str) -> dict[str, Table]:
    import pandas as pd

    index = frame.index
    if index.nlevels > 1 or frame.columns.nlevels > 1:
        advice = "expected times [s] and names; see droplevel of pandas"
        raise SignalError(f"{label}: has an index or columns of several levels; {advice}")
    if "time" not in frame.columns:
        if index.name != "time" and isinstance(index, pd.RangeIndex):
            what = "no column 'time', and its index numbers the rows"
            raise SignalError(f"{label}: {what}; expected times [s] in one of them")
        frame = frame.reset_index(names="time")
    names = [str(name) for name in frame.columns]
    if len(set(names)) < len(names) or names == ["time"]:
        raise SignalError(f"{label}: expected distinct columns beside 'time', got {names}")
    try:
        columns = {n: _numbers(frame[column]) for n, column in zip(names, frame, strict=True)}
        time = columns.pop("time")
        return {name: Table(time, column) for name, column in columns.items()}
    except SignalError as fault:
        raise SignalError(f"{label}: {fault}") from None
    except (TypeError, ValueError) as fault:
        raise SignalError(f"{label}: holds a value that is not a number: {fault}") from None


def _numbers(column: pd.Series) -> Array:
    """Return the values (n,) of a column; differences of time in seconds."""
    if hasattr(column.dtype, "units"):  # of Pint
        raise SignalError(
            f"column {column.name!r} holds quantities in {column.dtype.units}; expected numbers in"
            " the unit of the input: column.pint.to(unit).pint.magnitude"
        )
    if column.dtype.kind == "m":
        return np.asarray(column.dt.total_seconds())
    if column.dtype.kind in "Mc":
        what = "of a time stamp for example the seconds since the first: (t - t[0]).total_seconds()"
        raise SignalError(f"column {column.name!r} holds {column.dtype}; expected numbers, {what}")
    return np.asarray(column, dtype=np.float64)


def _arrow(error: type[CosimError], path: Path) -> ModuleType | Any:
    try:
        import pyarrow
    except ImportError:
        advice = f"install it with {installing('parquet')}"
        raise error(f"{path}: Parquet files need pyarrow; {advice}") from None
    return pyarrow


MOST_BYTES = 1 << 30
MOST_VALUES = 100_000_000
_INDEX = re.compile(r"__index_level_\d+__")  # of a frame, which pandas stores as a column


class Unreadable(ValueError):
    """The bytes are not a Parquet file of columns; the message does not name the file."""


@dataclass(frozen=True, eq=False)
class Column:
    """A column: its type, numbers (n,) with nan where there is none, and the unit of times."""

    kind: str
    numbers: NDArray[np.float64] | None = None
    unit: str | None = None


def read_parquet(data: bytes) -> dict[str, Column]:
    """Return the columns of a file by name."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        file = pq.ParquetFile(io.BytesIO(data))
        schema = file.schema_arrow
        names = [name for name in schema.names if not _INDEX.fullmatch(name)]
        kinds = {name: schema.field(name).type for name in names if names.count(name) == 1}
        wanted = [name for name, kind in kinds.items() if _holds_numbers(pa, kind)]
        groups = map(file.metadata.row_group, range(file.metadata.num_row_groups))
        rows, size = file.metadata.num_rows, sum(group.total_byte_size for group in groups)
        if rows * max(1, len(wanted)) > MOST_VALUES or size > 8 * MOST_BYTES:
            raise Unreadable(f"{rows} rows of {len(wanted)} columns; at most {MOST_VALUES} values")
        table = file.read(columns=wanted, use_threads=False)
        if twice := [name for name in names if name not in kinds]:
            raise Unreadable(f"two columns {shown(twice[0])}")
        if table.column_names != wanted or len(table) != rows:
            raise Unreadable("its parts contradict each other")
        return {
            name: _column(pa, kind, table[name]) if name in wanted else Column(str(kind))
            for name, kind in kinds.items()
        }
    except (pa.ArrowException, OSError, ValueError, KeyError, OverflowError) as fault:
        raise Unreadable(printable(" ".join(str(fault).split()))) from None


def _holds_numbers(pa: Any, kind: Any) -> bool:
    t = pa.types
    tests = (t.is_timestamp, t.is_duration, t.is_integer, t.is_floating, t.is_boolean)
    return bool(t.is_primitive(kind)) and any(test(kind) for test in tests)


def _column(pa: Any, kind: Any, values: Any) -> Column:
    unit = None
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        values, unit = values.cast(pa.int64()), kind.unit
    elif pa.types.is_boolean(kind):
        values = values.cast(pa.int8())
    with np.errstate(invalid="ignore"):  # odd kinds of NaN
        return Column(str(kind), np.asarray(values.to_numpy(), dtype=np.float64), unit)
