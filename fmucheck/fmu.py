"""An unpacked FMU: what rules about files and binaries are given."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stickslip.fmucheck.description.model import Description


@dataclass(frozen=True)
class Fmu:
    """An FMU in a folder of its own.

    ``members`` are the paths of all files in the archive, with forward slashes.
    """

    path: Path
    folder: Path
    members: frozenset[str]
    description: Description

    def bytes(self, name: str) -> bytes:
        """Return a member's content."""
        return (self.folder / name).read_bytes()

    def below(self, prefix: str) -> list[str]:
        """Return the members below a folder, sorted."""
        return sorted(name for name in self.members if name.startswith(prefix))

    @property
    def identifiers(self) -> list[str]:
        """The names of the binaries, each once."""
        return list(dict.fromkeys(each.identifier for each in self.description.interfaces))
