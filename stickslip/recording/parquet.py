"""Logs as Parquet files."""

from __future__ import annotations

import io

import numpy as np

from stickslip.errors import RecordingError
from stickslip.measurement import Array
from stickslip.recording.dialect import split_unit
from stickslip.recording.table import LogTable


def read_parquet(path: str, data: bytes) -> LogTable:
    """Read the numeric columns of a Parquet file; points in time become seconds.

    Raises
    ------
    RecordingError
        When pyarrow is missing, the file cannot be read, or it holds no rows of numbers.
    """
    try:
        import pyarrow as pa
        import pyarrow.parquet as pq
    except ImportError:
        raise RecordingError(
            f"{path}: reading Parquet needs pyarrow; install stickslip[parquet]"
        ) from None
    try:
        table = pq.read_table(io.BytesIO(data))
    except (pa.ArrowException, OSError, ValueError) as error:
        said = " ".join(str(error).split())[:80]
        raise RecordingError(f"{path}: not a Parquet file, or damaged ({said})") from None
    names: list[str] = []
    numbers: dict[str, Array] = {}
    units: dict[str, str] = {}
    faults: dict[str, str] = {}
    for label, column in zip(table.column_names, table.columns, strict=True):
        name, unit = split_unit(label)
        if name in names:
            name = label
        names.append(name)
        if pa.types.is_timestamp(column.type) or pa.types.is_duration(column.type):
            column, unit = column.cast(pa.int64()), column.type.unit
        if not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
            faults[name] = f"expected numbers, got {column.type}"
            continue
        numbers[name] = np.asarray(column.to_numpy(), dtype=np.float64)
        if unit:
            units[name] = unit
    if not numbers or not len(table):
        raise RecordingError(f"{path}: no rows of numbers; expected columns of numbers")
    return LogTable(path, tuple(names), numbers, units=units, faults=faults)
