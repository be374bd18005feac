"""The sound FMU, and defects that are seeded into it."""

import base64
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tests.corpus import fmu
from tests.corpus.fmu import archive as pack

HERE = Path(__file__).parent
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNk+A8AAQUBAScY42YAAAAASUVORK5CYII="
)
_MARK = b"DEFECT=none"

Members = dict[str, bytes]


def binary_name(version: int) -> str:
    """Return the path of this machine's binary in the FMU."""
    return fmu.place("reference", version)


@cache
def library() -> bytes:
    """Return the compiled model, which has no defect."""
    flags = ("-Wno-conversion", "-Wno-variadic-macro-arguments-omitted", "-Wno-pedantic")
    return fmu.library("reference", HERE / "model.c", flags=flags).read_bytes()


def with_defect(defect: str) -> bytes:
    """Return the compiled model with one defect switched on."""
    binary = library()
    mark = b"DEFECT=" + defect.encode() + b"."
    place = binary.index(_MARK)
    return binary[:place] + mark + binary[place + len(mark) :]


def members(version: int) -> Members:
    """Return the files of the sound FMU."""
    build = (HERE / "build.xml").read_bytes()
    terminals = (HERE / "terminals.xml").read_bytes()
    return {
        "modelDescription.xml": (HERE / f"description{version}.xml").read_bytes(),
        binary_name(version): library(),
        "sources/model.c": (HERE / "model.c").read_bytes(),
        "sources/buildDescription.xml": build,
        "terminalsAndIcons/terminalsAndIcons.xml": terminals,
        "terminalsAndIcons/icon.png": PIXEL,
        "terminalsAndIcons/port.png": PIXEL,
        "documentation/index.html": b"<!DOCTYPE html><title>reference</title>",
        "documentation/licenses/license.txt": b"MIT",
    }


Writer = Callable[[Path, Members], None]


@dataclass(frozen=True)
class Seed:
    """A defect."""

    theme: str
    version: int
    rule: str  # the one that must find it
    what: str  # a few words for the table
    write: Writer  # writes the defective FMU, given the files of the sound one

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
