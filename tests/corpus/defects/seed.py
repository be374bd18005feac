"""One seeded defect, and how it gets into the sound FMU."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from tests.corpus.defects.reference import Members, members, pack

Writer = Callable[[Path, Members], None]


@dataclass(frozen=True)
class Seed:
    """A defect.

    Attributes
    ----------
    rule : the one that must find it
    what : a few words for the table
    write : writes the defective FMU, given the files of the sound one
    """

    theme: str
    version: int
    rule: str
    what: str
    write: Writer

    @property
    def name(self) -> str:
        """A name for the test."""
        return f"{self.version}-{self.rule}-{self.what}".replace(" ", "_")

    def make(self, folder: Path) -> Path:
        """Write the defective FMU."""
        path = folder / "reference.fmu"
        self.write(path, members(self.version))
        return path


def replaced(file: str, *pairs: tuple[str, str]) -> Writer:
    """Return a writer that replaces texts in one file, every time they occur."""

    def write(path: Path, content: Members) -> None:
        text = content[file].decode()
        for old, new in pairs:
            if old not in text:
                raise ValueError(f"{file} has no {old}")
            text = text.replace(old, new)
        pack(path, content | {file: text.encode()})

    return write


def with_files(files: dict[str, bytes | None]) -> Writer:
    """Return a writer that adds files, and removes those that are ``None``."""

    def write(path: Path, content: Members) -> None:
        kept = {name: data for name, data in content.items() if name not in files}
        pack(path, kept | {name: data for name, data in files.items() if data is not None})

    return write
