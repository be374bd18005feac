"""The input that a system structure package runs with when it is given no other.

It lies in the package as ``extra/stickslip/input.csv``: a place that SSP 1.0 leaves to tools, so
others open the package as before.
"""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import TYPE_CHECKING

from stickslip.cosim import Table
from stickslip.cosim.ssp.package import Package
from stickslip.fmi.files import atomic_write

if TYPE_CHECKING:
    import pandas as pd

MEMBER = "extra/stickslip/input.csv"


def pack_input(package: Path, table: pd.DataFrame) -> None:
    """Add a table with a column ``time`` [s] and one per exposed input to an .ssp file."""
    stream = io.BytesIO(package.read_bytes())
    with zipfile.ZipFile(stream, "a", zipfile.ZIP_DEFLATED) as archive:
        info = zipfile.ZipInfo(MEMBER, (1980, 1, 1, 0, 0, 0))
        info.compress_type = zipfile.ZIP_DEFLATED
        archive.writestr(info, table.to_csv(index=False, lineterminator="\n"))
    atomic_write(package, stream.getvalue())


def packed_input(package: Path) -> dict[str, Table]:
    """Return the signals of a package by exposed input; empty when it has none.

    Raises SignalError when they cannot be read, or SspError when the package cannot be.
    """
    file = Package.open(package).folder / MEMBER
    return Table.all_from_csv(file) if file.is_file() else {}
