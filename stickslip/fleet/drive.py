"""One drive of a fleet, and where its recording comes from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from stickslip.servo.systems import Changes


@dataclass(frozen=True)
class LogSource:
    """A recording in a file.

    Attributes
    ----------
    log : CSV, Parquet or MAT
    config : TOML file that describes it; None leaves it to guesses
    """

    log: Path
    config: Path | None = None


@dataclass(frozen=True)
class Variant:
    """A drive FMU that is recorded when its turn comes.

    Attributes
    ----------
    changes : parameters that differ from Table 2, in the units of the drive's model.toml
    """

    changes: Changes


@dataclass(frozen=True)
class Drive:
    """A row of a fleet's table.

    Attributes
    ----------
    name : unique, and fit to name a folder
    source : of its recording
    row : its cells as they were written, by column
    """

    name: str
    source: LogSource | Variant
    row: Mapping[str, str]
