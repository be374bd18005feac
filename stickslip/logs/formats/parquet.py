"""Logs as Parquet files."""

from stickslip.errors import RecordingError
from stickslip.fmi.messages import printable
from stickslip.logs.header import split_unit
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array

TITLE = "Parquet"
SUFFIXES = (".parquet", ".pq")
BEGINS = (b"PAR1",)
NEEDS = ("pyarrow", "parquet")


def read(path: str, data: bytes) -> LogTable:
    """Read the numeric columns of a Parquet file; points in time become seconds.

    Raises RecordingError when the file cannot be read, or it holds no rows of numbers.
    """
    from stickslip.cosim.signals.tables import Unreadable, read_parquet  # late: loads cosim

    try:
        columns = read_parquet(data)
    except Unreadable as error:
        raise RecordingError(f"{path}: not a Parquet file, or damaged ({error})") from None
    names: list[str] = []
    numbers: dict[str, Array] = {}
    units: dict[str, str] = {}
    faults: dict[str, str] = {}
    for label, column in columns.items():
        name, unit = split_unit(label)
        if name in names:
            name = label
        names.append(name)
        if column.numbers is None or column.kind == "bool":
            faults[name] = f"expected numbers, got {printable(column.kind)}"
            continue
        numbers[name] = column.numbers
        if unit := column.unit or unit:
            units[name] = unit
    if not any(len(column) for column in numbers.values()):
        raise RecordingError(f"{path}: no rows of numbers; expected columns of numbers")
    return LogTable(path, tuple(names), numbers, units=units, faults=faults)
