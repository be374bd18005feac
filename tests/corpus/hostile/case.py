"""A hostile input: how it is made, and what is said of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

Make = Callable[[Path], Sequence[str | Path]]
"""Writes files into an empty folder; returns the arguments of ``stickslip`` that feed them."""


@dataclass(frozen=True)
class Case:
    """One row of the table.

    Parameters
    ----------
    group : what it attacks, a key of `GROUPS`
    name : of its own
    about : what is hostile about it, for the table
    make : makes it
    says : regular expression that the line matches which the command ends with
    """

    group: int
    name: str
    about: str
    make: Make
    says: str

    def __str__(self) -> str:
        return f"{self.group}-{self.name}"


GROUPS = {
    1: "names of members",
    2: "links",
    3: "archives that grow",
    4: "damaged archives",
    5: "the description as a file",
    6: "XML that attacks its reader",
    7: "versions of FMI",
    8: "names and references of variables",
    9: "references inside the description",
    10: "identifiers as paths",
    11: "numbers of the description",
    12: "dimensions of arrays",
    13: "characters in names",
    14: "binaries that do not load",
    15: "instances refused",
    16: "binaries that attack their process",
    17: "statuses",
    18: "values",
    19: "states that are not restored",
    20: "numbers of instances",
    21: "systems",
    22: "tables of inputs and logs",
    23: "learning",
}
"""What a case attacks."""
