"""Tables and plain data as files, and documents that are kept while a command runs."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from stickslip.fmi.files import MOST_TEXT, atomic_write, parse_json, read_limited


def write_tables(tables: Mapping[str, pd.DataFrame], folder: Path) -> None:
    """Write tables as CSV files by name."""
    for name, table in tables.items():
        atomic_write(folder / f"{name}.csv", table.to_csv(index=False, lineterminator="\n"))


def write_json(content: object, path: Path) -> None:
    """Write plain data as JSON."""
    atomic_write(path, json.dumps(content, indent=2) + "\n")


def read_kept(path: Path, expected: Mapping[str, Any]) -> dict[str, Any] | None:
    """Return the document of an earlier run, None unless it has the expected entries."""
    try:
        document = parse_json(read_limited(path, MOST_TEXT))
    except (OSError, ValueError):
        return None
    known = isinstance(document, dict) and expected.items() <= document.items()
    return document if known else None
