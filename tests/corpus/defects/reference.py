"""The sound FMU: both interfaces, everything that a description can say, all abilities."""

from __future__ import annotations

import base64
import zipfile
from functools import cache
from pathlib import Path

from stickslip.fmi import toolchain
from tests.corpus import fmu

HERE = Path(__file__).parent
PIXEL = base64.b64decode(
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNk+A8AAQUBAScY42YAAAAASUVORK5CYII="
)
_MARK = b"DEFECT=none"

Members = dict[str, bytes]


def binary_name(version: int, suffix: str | None = None) -> str:
    """Return the path of this machine's binary in the FMU."""
    platform = toolchain.host_platform()
    folder = platform.fmi2 if version == 2 else platform.tuple
    return f"binaries/{folder}/reference{suffix or platform.suffix}"


@cache
def library(version: int) -> bytes:
    """Return the compiled model, which has no defect."""
    sources = (HERE / "model.c", HERE / f"fmi{version}.h")
    flags = (f"-DFMI={version}", "-Wno-conversion", "-Wno-unused-function")
    return fmu.library("reference", *sources, flags=flags, versions=[version]).read_bytes()


def with_defect(version: int, defect: str) -> bytes:
    """Return the compiled model with one defect switched on."""
    binary = library(version)
    mark = b"DEFECT=" + defect.encode() + b"."
    place = binary.index(_MARK)
    return binary[:place] + mark + binary[place + len(mark) :]


def members(version: int) -> Members:
    """Return the files of the sound FMU."""
    build = (HERE / "build.xml").read_bytes()
    terminals = (HERE / "terminals.xml").read_bytes()
    return {
        "modelDescription.xml": (HERE / f"description{version}.xml").read_bytes(),
        binary_name(version): library(version),
        "sources/model.c": (HERE / "model.c").read_bytes(),
        "sources/buildDescription.xml": build,
        "terminalsAndIcons/terminalsAndIcons.xml": terminals,
        "terminalsAndIcons/icon.png": PIXEL,
        "terminalsAndIcons/port.png": PIXEL,
        "documentation/index.html": b"<!DOCTYPE html><title>reference</title>",
        "documentation/licenses/license.txt": b"MIT",
    }


def pack(path: Path, content: Members) -> Path:
    """Write files into an FMU."""
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return path
