"""Logs as Parquet files."""

from stickslip.logs.signals import Signal

TITLE = "Parquet"
SUFFIXES = (".parquet", ".pq")
BEGINS = (b"PAR1",)
NEEDS = ("pyarrow", "parquet")


def signals(data: bytes) -> list[Signal]:
    """Return the columns; points in time become seconds."""
    from stickslip.cosim.signals.tables import read_parquet  # late: loads cosim

    return [
        Signal(label, column.numbers, column.unit or "", instead=column.kind)
        for label, column in read_parquet(data).items()
    ]
