"""Parsers of archives, binaries and the XML of an FMU."""

import io
import re
import struct
import zipfile
import zlib
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io
from lxml import etree

from campaigns.fuzz.campaign import Parser, from_file
from campaigns.fuzz.mutation import NUMBERS, mutated
from stickslip import cosim, fmucheck
from stickslip.cosim.run.checkpoint import Checkpoint
from stickslip.errors import RecordingError
from stickslip.fmi import toolchain
from stickslip.fmi.binary import NotALibrary, read_library, universal
from stickslip.fmi.description import DescriptionFault, read_description
from stickslip.fmi.xml import Malformed, parse_xml
from stickslip.logs.formats import read_table
from tests.corpus.defects.reference import HERE, members

_WORDS = (
    *("input", "output", "local", "parameter", "structuralParameter", "independent", "constant"),
    *("continuous", "discrete", "fixed", "tunable", "exact", "approx", "calculated", "true", "2.0"),
    *("3.0", "=cmd", "\u202e\u00e4'\"", "x" * 10_000, "../..", "con", "0 0 0", "1 2 3 4 5 6 7 8"),
    *(number.decode() for number in NUMBERS),
)
_ARRAY = b"""<fmiModelDescription fmiVersion="3.0" modelName="a" instantiationToken="a">
<CoSimulation modelIdentifier="a"/><ModelVariables>
<UInt64 name="n" valueReference="1" causality="structuralParameter" start="2"/>
<Clock name="c" valueReference="2" causality="input" intervalVariability="fixed" resolution="10"
 intervalCounter="1"/><Binary name="b" valueReference="3" causality="input"><Start value="00ff"/>
</Binary><Int32 name="m" valueReference="4" causality="parameter" start="1 2 3 4" min="0" max="9">
<Dimension valueReference="1"/><Dimension start="2"/></Int32></ModelVariables><ModelStructure/>
</fmiModelDescription>"""


def descriptions() -> list[bytes]:
    sources = [(HERE / f"description{version}.xml").read_bytes() for version in (2, 3)]
    return [*(re.sub(rb">\s+<", b"><", source) for source in sources), _ARRAY]


def other_description(rng: Random, data: bytes) -> bytes:
    """Return it with some attributes, elements or texts changed, still well-formed."""
    root = etree.fromstring(data)
    for _ in range(rng.randint(1, 3)):
        elements = list(root.iter("*"))
        rng.choice(_EDITS)(rng, rng.choice(elements), elements)
    return etree.tostring(root)


def _value(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    if element.attrib:
        key = rng.choice(element.keys())
        others = [other.get(key) for other in elements if key in other.attrib]
        element.set(key, rng.choice(rng.choice((_WORDS, others))))


def _attribute(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    donor = rng.choice(elements)
    if donor.attrib:
        key = rng.choice(donor.keys())
        element.set(key, donor.get(key))


def _drop(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    if element.attrib and rng.random() < 0.7:
        del element.attrib[rng.choice(element.keys())]
    elif element is not elements[0]:
        element.getparent().remove(element)


def _move(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    donor = etree.fromstring(etree.tostring(rng.choice(elements[1:] or elements)))
    element.insert(rng.randint(0, len(element)), donor)


def _rename(rng: Random, element: etree._Element, elements: list[etree._Element]) -> None:
    element.tag = rng.choice(elements).tag


_EDITS = (_value, _value, _value, _value, _attribute, _drop, _move, _rename)


_PLACES = {
    b"<fmiBuildDescription": "sources/buildDescription.xml",
    b"<fmiTerminalsAndIcons": "terminalsAndIcons/terminalsAndIcons.xml",
}


class CheckErrors(Exception):
    """The check found errors."""


def checked_files() -> list[bytes]:
    sound = members(3)
    return [*descriptions()[:2], *(sound[place] for place in _PLACES.values())]


def check(data: bytes, folder: Path) -> None:
    version = 2 if b'fmiVersion="2' in data else 3
    place = next((place for mark, place in _PLACES.items() if mark in data), "modelDescription.xml")
    path = folder / "checked.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in (members(version) | {place: data}).items():
            archive.writestr(name, content)
    try:
        report = fmucheck.check(path, run=False)
    finally:
        path.unlink()
    if report.count(fmucheck.Severity.ERROR):
        raise CheckErrors


_CODE = '__attribute__((visibility("default"))) double twice(double x) { return x + x; }\n'
_VALUES = (0, 1, 7, 8, 24, 255, 2**15, 2**16 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1)


def libraries() -> list[bytes]:
    each = {
        name: toolchain.shared_library(
            "twice", {"a.c": _CODE}, platform=platform, standalone=True
        ).read_bytes()
        for name, platform in toolchain.PLATFORMS.items()
    }
    apple = [data for name, data in each.items() if "darwin" in name]
    return [*each.values(), universal(apple)]


def other_library(rng: Random, data: bytes) -> bytes:
    """Return it with some numbers of its headers and tables changed."""
    changed = bytearray(data)
    used = [place for place in range(0, len(data) - 8, 4) if data[place : place + 4] != bytes(4)]
    for _ in range(rng.randint(1, 4)):
        place = rng.choice(used[: rng.choice((40, 400, len(used)))])
        size = rng.choice("BHIQ")
        near = struct.unpack_from(f"<{size}", data, place)[0] + rng.randint(-9, 9)
        value = rng.choice((near, rng.choice(_VALUES), len(data) - rng.randrange(64)))
        struct.pack_into(f"<{size}", changed, place, value % 2 ** (8 * struct.calcsize(size)))
    return bytes(changed)


_HEADER = 128
_WORD_SIZES = (0, 1, 2, 4, 5, 6, 7, 9, 14, 15, 255, 2**16, 2**31 - 1, 2**31, 2**32 - 8, 2**32 - 1)


def _packed(content: dict[str, object], *, compressed: bool = False) -> bytes:
    stream = io.BytesIO()
    scipy.io.savemat(stream, content, do_compression=compressed)
    return stream.getvalue()


def mat_files() -> list[bytes]:
    t = np.arange(30) * 1e-3
    log = {"t": t, "x": np.sin(t)[:, None], "kp": 3.0}
    kinds = {
        "s": {"t": t, "inner": {"x": t, "deep": {"y": t.astype(np.float32)}}},
        "text": "abc",
        "cells": np.array(["a", 1], dtype=object),
        "z": t * 1j,
        "m": np.arange(12, dtype=np.int16).reshape(3, 4),
        "cube": np.zeros((2, 2, 2), np.uint8),
        "flag": np.array([True, False]),
        "none": np.zeros((0, 3)),
    }
    return [_packed(log), _packed(log, compressed=True), _packed(kinds), _packed({"x": t})]


def other_mat(rng: Random, data: bytes) -> bytes:
    """Change words of four bytes; pack the elements afterwards, or unpack and pack them again."""
    head, body = data[:_HEADER], bytearray(data[_HEADER:])
    if len(body) > 8 and body[0] == 15:
        body = bytearray(zlib.decompress(body[8:]))
    for _ in range(rng.randint(1, 3)):
        place = 4 * rng.randrange(max(1, min(len(body), 400) // 4))
        word = rng.choice(_WORD_SIZES) if rng.random() < 0.7 else rng.getrandbits(32)
        body[place : place + 4] = struct.pack("<I", word)
    if rng.random() < 0.3:
        packed = zlib.compress(bytes(body))
        body = bytearray(struct.pack("<II", 15, len(packed)) + packed)
    return head + bytes(body)


def _parquet(columns: dict[str, object], **how: object) -> bytes:
    stream = io.BytesIO()
    pq.write_table(pa.table(columns), stream, **how)
    return stream.getvalue()


def parquet_files() -> list[bytes]:
    t = np.arange(64) * 1e-3
    plain = {"time": t, "x": np.sin(9 * t), "n": np.arange(64) % 3}
    kinds = {
        "time": pa.array(range(20), pa.timestamp("us")),
        "x": pa.array([None, *range(19)], pa.float32()),
        "text": ["a"] * 20,
        "nested": [{"a": k, "b": [k] * 3} for k in range(20)],
        "flag": [True, False] * 10,
        "decimal": pa.array(range(20)).cast(pa.decimal128(30, 2)),
    }
    small = {"time": [0.0, 1.0], "u": [1, 2]}
    return [
        _parquet(plain, compression="none", use_dictionary=False),
        _parquet(plain),
        _parquet(plain, compression="zstd", row_group_size=20, data_page_version="2.0"),
        _parquet(plain, compression="gzip", use_dictionary=["n"], write_statistics=False),
        _parquet(kinds, compression="none"),
        _parquet(small, compression="none", store_schema=False),
        _parquet(
            small,
            compression="lz4",
            use_dictionary=False,
            column_encoding={"time": "BYTE_STREAM_SPLIT", "u": "DELTA_BINARY_PACKED"},
        ),
    ]


def parquet(file: Path) -> None:
    try:
        read_table(file)
    finally:
        cosim.read_tables(file)


def other_parquet(rng: Random, data: bytes) -> bytes:
    """Change numbers of the description at the end, or of one page, and nothing else."""
    size = int.from_bytes(data[-8:-4], "little")
    begin = len(data) - 8 - size
    changed = bytearray(data)
    first, last = (begin, len(data) - 8) if rng.random() < 0.6 else (4, begin)
    for _ in range(rng.randint(1, 3)):
        changed[rng.randrange(first, last)] = rng.choice((0, 1, 2, 0x7F, 0xFF, rng.randrange(256)))
    return bytes(changed)


def states() -> list[bytes]:
    row, memory = np.arange(3.0), {"a/times": np.zeros(2), "/x": np.ones(4)}
    saved = Checkpoint({"step": "0.1"}, 5, row, {"a": b"state"}, {"a.k": 2.0}, memory)
    with TemporaryDirectory() as folder:
        return [saved.write(Path(folder) / "state").read_bytes()]


def other_state(rng: Random, data: bytes) -> bytes:
    """Change one member and pack all again."""
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old, zipfile.ZipFile(stream, "w") as new:
        names = old.namelist()
        for name, changed in zip(names, rng.sample(names, len(names)), strict=True):
            content = old.read(name)
            new.writestr(name, mutated(rng, content, [content]) if name == changed else content)
    return stream.getvalue()


PARSERS = {
    "description": Parser(
        lambda data, _: read_description(parse_xml(data)),
        descriptions,
        other_description,
        (Malformed, DescriptionFault),
    ),
    "check": Parser(check, checked_files, other_description, (CheckErrors,)),
    "library": Parser(lambda data, _: read_library(data), libraries, other_library, (NotALibrary,)),
    "mat": Parser(from_file("log.mat", read_table), mat_files, other_mat, (RecordingError,)),
    "parquet": Parser(
        from_file("in.parquet", parquet),
        parquet_files,
        other_parquet,
        (cosim.SignalError, RecordingError),
    ),
    "state": Parser(
        from_file("state", Checkpoint.read), states, other_state, (cosim.SimulationError,)
    ),
}
