"""Columns of untrusted Parquet files: only those that hold numbers are unpacked."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.fmi.messages import printable, shown

MOST_BYTES = 1 << 30
MOST_VALUES = 100_000_000

_INDEX = re.compile(r"__index_level_\d+__")  # of a frame, which pandas stores as a column


class Unreadable(ValueError):
    """The bytes are not a Parquet file of columns; the message does not name the file."""


@dataclass(frozen=True, eq=False)
class Column:
    """A column.

    Attributes
    ----------
    kind : Arrow's name of its type
    numbers : (n,) nan where there is none; None in columns of other types
    unit : of times: s, ms, us or ns
    """

    kind: str
    numbers: NDArray[np.float64] | None = None
    unit: str | None = None


def read_columns(data: bytes) -> dict[str, Column]:
    """Return the columns of a file by name.

    Raises
    ------
    ImportError
        When pyarrow is not installed.
    Unreadable
        When the file is damaged, holds too much or two columns of one name.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        file = pq.ParquetFile(io.BytesIO(data))
        schema = file.schema_arrow
        names = [name for name in schema.names if not _INDEX.fullmatch(name)]
        kinds = {name: schema.field(name).type for name in names if names.count(name) == 1}
        wanted = [name for name, kind in kinds.items() if _holds_numbers(pa, kind)]
        rows, size = file.metadata.num_rows, _unpacked(file.metadata)
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
    is_time = pa.types.is_timestamp(kind) or pa.types.is_duration(kind)
    return bool(pa.types.is_primitive(kind)) and bool(
        is_time
        or pa.types.is_integer(kind)
        or pa.types.is_floating(kind)
        or pa.types.is_boolean(kind)
    )


def _unpacked(metadata: Any) -> int:
    """Return how large the pages are when they are unpacked, by the file's own account."""
    return sum(metadata.row_group(k).total_byte_size for k in range(metadata.num_row_groups))


def _column(pa: Any, kind: Any, values: Any) -> Column:
    unit = None
    if pa.types.is_timestamp(kind) or pa.types.is_duration(kind):
        values, unit = values.cast(pa.int64()), kind.unit
    elif pa.types.is_boolean(kind):
        values = values.cast(pa.int8())
    with np.errstate(invalid="ignore"):  # odd kinds of NaN
        return Column(str(kind), np.asarray(values.to_numpy(), dtype=np.float64), unit)
