"""Tables and plain data as files."""

import json
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

from stickslip.fmi.files import atomic_write


def write_tables(tables: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Write tables as CSV files by name."""
    for name, table in tables.items():
        atomic_write(folder / f"{name}.csv", table.to_csv(index=False, lineterminator="\n"))


def write_json(content: object, path: Path) -> None:
    """Write plain data as JSON."""
    atomic_write(path, json.dumps(content, indent=2) + "\n")
