"""The XML of an FMU as ``stickslip check`` judges it, with all around it sound."""

from __future__ import annotations

import zipfile
from pathlib import Path
from random import Random

from stickslip import fmucheck
from tests.corpus.defects.reference import members
from tests.corpus.fuzz.parsers import description

_PLACES = {
    b"<fmiBuildDescription": "sources/buildDescription.xml",
    b"<fmiTerminalsAndIcons": "terminalsAndIcons/terminalsAndIcons.xml",
}


class Faulty(Exception):
    """The judge found errors."""


EXPECTED = (Faulty,)


def corpus() -> list[bytes]:
    sound = members(3)
    return [*description.corpus()[:2], *(sound[place] for place in _PLACES.values())]


def parse(data: bytes, folder: Path) -> None:
    version = 2 if b'fmiVersion="2' in data else 3
    place = next((place for mark, place in _PLACES.items() if mark in data), "modelDescription.xml")
    path = folder / "judged.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in (members(version) | {place: data}).items():
            archive.writestr(name, content)
    try:
        report = fmucheck.check(path, run=False)
    finally:
        path.unlink()
    if report.count(fmucheck.Severity.ERROR):
        raise Faulty


def mutate(rng: Random, data: bytes) -> bytes:
    return description.mutate(rng, data)
