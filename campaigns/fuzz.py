"""``python -m campaigns.fuzz --parser NAME --inputs N --seed S``: inputs changed at random.

They are made from sound ones, and from the malformed ones of ``tests/corpus/hostile``. Inputs that
end otherwise than they should are saved; ``--first`` goes on where a hunt was. A process that died
is told by its exit status and a traceback.
"""

import argparse
import faulthandler
import io
import json
import logging
import re
import struct
import tempfile
import time
import traceback
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from random import Random
from unittest import mock

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import scipy.io

from stickslip import cosim, fmucheck, ga
from stickslip.cosim.run.checkpoint import Checkpoint
from stickslip.cosim.ssp.markup import violation
from stickslip.errors import RecordingError, StickslipError, UsageError
from stickslip.fmi import toolchain
from stickslip.fmi.binary import NotALibrary, read_library, universal
from stickslip.fmi.description import DescriptionFault, read_description
from stickslip.fmi.xml import Malformed, parse_xml
from stickslip.ga.execution import checkpoint
from stickslip.learned.file import LearnedFile
from stickslip.logs import Description, load_description, raise_errors, read_and_check
from stickslip.logs.formats import read_table
from stickslip.studies.fleet.table import read_fleet
from tests.corpus.defects import reference
from tests.corpus.hostile import CASES
from tests.corpus.hostile import packages as ssp
from tests.stickslip.logs.test_malformed import TOML
from tests.stickslip.logs.test_vendors import FILES

_NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
_TOKEN = re.compile(rb"[\w.+-]+|\s+|.", re.DOTALL)
NUMBERS = (
    *(b"0", b"-0", b"1", b"-1", b"1e400", b"-1e400", b"1e-400", b"NaN", b"INF", b"-INF", b"inf"),
    *(b"2147483648", b"-2147483649", b"4294967296", b"18446744073709551616", b"9" * 5000),
    *(b"", b" ", b"0x10", b"1_000", b"1,5", b"1e", b".", b"true", "\u0661".encode()),
)
TOKENS = (
    *(b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\xc3(", b"\r\n", b"\n", b'"', b"'", b"<", b"&", b"{"),
    *(b"../", b"C:\\", b"/", b"\\", b",", b";", b"=", b"[", b"]", b"A" * 300, b"[" * 2000),
)
WHOLE = (0, 1, 7, 15, 255, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1)


def _stretch(rng: Random, data: bytes, mean: int) -> tuple[int, int]:
    begin = rng.randint(0, len(data))
    return begin, min(len(data), begin + int(rng.expovariate(1 / mean)))


def by_bytes(rng: Random, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """Change one to four stretches without regard to their meaning."""
    for _ in range(rng.randint(1, 4)):
        begin, end = _stretch(rng, data, 20)
        part = data[begin:end]
        match rng.randrange(9):
            case 0:
                end = begin + 1
                part = bytes(byte ^ 1 << rng.randrange(8) for byte in data[begin:end])
            case 1:
                part = rng.randbytes(end - begin)
            case 2:
                part = b""
            case 3:
                part *= rng.choice((2, 3, 50))
            case 4:
                part = rng.choice(TOKENS) + part
            case 5:
                part, end = b"", len(data)
            case 6:
                other = rng.choice(corpus)
                first, last = _stretch(rng, other, 20)
                part = other[first:last] + part
            case _ if found := _NUMBER.search(data, begin):
                begin, end = found.span()
                part = rng.choice(NUMBERS)
        data = data[:begin] + part + data[end:]
    return data


def by_words(rng: Random, data: bytes, corpus: Sequence[bytes]) -> bytes:
    """Drop, repeat, insert or replace one to three stretches of a text, and leave words whole."""
    tokens = _TOKEN.findall(data) or [b""]
    for _ in range(rng.randint(1, 3)):
        begin = rng.randrange(len(tokens) + 1)
        end = min(len(tokens), begin + int(rng.expovariate(1 / 4)))
        word = rng.choice(_TOKEN.findall(rng.choice(corpus)) or [b""])
        match rng.randrange(6):
            case 0:
                tokens[begin:end] = []
            case 1:
                tokens[begin:end] *= rng.choice((2, 3, 40))
            case 2:
                tokens[begin:begin] = [word]
            case _:
                tokens[begin : begin + 1] = [rng.choice((word, rng.choice(NUMBERS)))]
    return b"".join(tokens)


def by_numbers(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    """Change one to four numbers of a binary, most of them in the tables at its begin or end."""
    changed = bytearray(data)
    used = [place for place in range(0, len(data) - 8, 4) if data[place : place + 4] != bytes(4)]
    for _ in range(rng.randint(1, 4)):
        near = rng.choice((40, 400, len(used)))
        place = rng.choice(rng.choice((used[:near], used[-near:])))
        size = rng.choice("BHIQ")
        number = struct.unpack_from(f"<{size}", data, place)[0] + rng.randint(-9, 9)
        number = rng.choice((number, rng.choice(WHOLE), len(data) - rng.randrange(64)))
        struct.pack_into(f"<{size}", changed, place, number % 2 ** (8 * struct.calcsize(size)))
    return bytes(changed)


def by_member(rng: Random, data: bytes, _: Sequence[bytes]) -> bytes:
    """Change one file of an archive, and pack all again."""
    try:
        old = zipfile.ZipFile(io.BytesIO(data))
        content = {name: old.read(name) for name in old.namelist()}
    except (zipfile.BadZipFile, ValueError):  # malformed already
        return data
    if names := [name for name in content if not name.endswith(".fmu")]:
        name = rng.choice(names)
        content[name] = rng.choice((by_bytes, by_words))(rng, content[name], [content[name]])
    return _zipped(content)


def _zipped(content: dict[str, bytes]) -> bytes:
    stream = io.BytesIO()
    reference.pack(stream, content)
    return stream.getvalue()


Change = Callable[[Random, bytes, Sequence[bytes]], bytes]
LONGEST = 20_000  # bytes of a malformed input that is changed further


@dataclass(frozen=True)
class Parser:
    """A parser, and inputs for it."""

    file: str  # the name by which it gets an input
    read: Callable[[Path], object]
    sound: Callable[[], list[bytes]]  # gives valid inputs
    change: Change  # keeps the structure, for half of the inputs; the others change as bytes
    expected: tuple[type[Exception], ...]  # by which an input may be refused

    @cached_property
    def corpus(self) -> list[bytes]:
        """The inputs from which all others are made."""
        found = [case.files[self.file] for case in CASES if self.file in case.files]
        texts = [one.encode() if isinstance(one, str) else one for one in found]
        return self.sound() + [x for x in texts if isinstance(x, bytes) and len(x) < LONGEST]

    def made(self, seed: int, i: int) -> bytes:
        """Return input i, which depends on the seed and i alone."""
        rng = Random(seed * 2**40 + i)  # noqa: S311 - no secrets
        change = self.change if rng.random() < 0.5 else by_bytes
        return change(rng, rng.choice(self.corpus), self.corpus)


TABLES = [
    b"time,u\n0,0\n0.5,1e-3\n1,2\n",
    b'\xef\xbb\xbf"time","a b",c\r\n0,1,2\r\n0,3,4\r\n1.5,-1,.5\r\n',
]
FLEETS = [
    b"name,log,config\na,a.csv,a.toml\nb,sub/b.mat,\n",
    b'\xef\xbb\xbfname,log\r\nx,"a, b.csv"\r\ny,c.csv\r\n',
]


def logs() -> list[bytes]:
    """Return logs as the tools of vendors write them, 90 lines of each."""
    texts = ["".join(text.splitlines(keepends=True)[:90]) for text in FILES.values()]
    return [*(text.encode("latin-1") for text in texts), texts[0].encode("utf-16")]


def read_log(file: Path) -> None:
    raise_errors(file, read_and_check(file, Description())[1])


def learned_files() -> list[bytes]:
    """Return the paper's learned.json."""
    return [(Path(__file__).parents[1] / "results" / "paper" / "learned.json").read_bytes()]


def read_learned(file: Path) -> None:
    learned = LearnedFile(file)
    for entry in (*("compensator", "drive", "drive_errors", "loop"), *("validation", "datasheet")):
        getattr(learned, entry)


def _algorithm() -> ga.Optimiser:
    genes = [ga.Gene("a", 0.0, 2.0, 1.0, linear=True), ga.Gene("b", 1.0, 10.0, 5.0, "m")]
    return ga.GeneticAlgorithm(genes, ga.Settings(population=4, surrogates=False), seed=7)


def checkpoints() -> list[bytes]:
    algorithm = _algorithm()
    for _ in range(2):
        algorithm.tell(algorithm.ask().sum(axis=1))
    return [json.dumps({"about": "", **algorithm.state()}).encode()]


def states() -> list[bytes]:
    row, memory = np.arange(3.0), {"a/times": np.zeros(2), "/x": np.ones(4)}
    saved = Checkpoint({"step": "0.1"}, 5, row, {"a": b"state"}, {"a.k": 2.0}, memory)
    with tempfile.TemporaryDirectory() as folder:
        return [saved.write(Path(folder) / "state").read_bytes()]


def system_packages() -> list[bytes]:
    """Return packages of both versions: units, nested systems, bindings, mappings, dictionaries."""
    metres = '<ssc:Real unit="m"/>'
    ends = ssp.connector("v", "input") + ssp.connector("x", "output", metres)
    dictionary = (
        '<ssd:SignalDictionaryReference name="d" dictionary="bus"><ssd:Connectors>'
        f"{ssp.connector('z', 'inout', metres)}</ssd:Connectors></ssd:SignalDictionaryReference>"
    )
    inner = [ssp.connection("v", "c.u"), ssp.connection("c.y", "x")]
    nested = ssp.system("inner", ssp.component("c"), inner, connectors=ends)
    scaled = '<ssc:LinearTransformation factor="2" offset="-1"/>'
    entry = f'<ssb:DictionaryEntry name="z">{metres}</ssb:DictionaryEntry>'
    mapped = '<ssm:MappingEntry source="k" target="a.k">' + scaled + "</ssm:MappingEntry>"
    source = '<ssd:SignalDictionary name="bus" source="a.ssb"/>'
    found = []
    for version in ("1.0", "2.0"):
        text = ssp.structure(
            ssp.component("a") + ssp.component("b", fmu=3) + dictionary + nested,
            [
                ssp.connection("a.y", "b.u", scaled),
                ssp.connection("b.y", "d.z"),
                *(ssp.connection(*ends) for ends in (("d.z", "inner.v"), ("inner.x", "x"))),
            ],
            connectors=ends,
            before=ssp.binding("a.ssv", "a.ssm"),
            behind=f"<ssd:SignalDictionaries>{source}</ssd:SignalDictionaries>",
            version=version,
        )
        files = {
            "a.ssv": ssp.values(("k", "1.5")),
            "a.ssm": ssp.document("ssm:ParameterMapping", mapped),
            "a.ssb": ssp.document("ssb:SignalDictionary", entry),
        }
        stream = io.BytesIO()
        ssp.packed(text, files)(stream)
        found.append(stream.getvalue())
    return found


def read_package(file: Path) -> None:
    """Read a package; half of them meet no schema, as where those of SSP 2.0 are not installed."""
    met = violation if file.stat().st_size % 2 else lambda *_: None
    with mock.patch("stickslip.cosim.ssp.markup.violation", met):
        cosim.read_ssp(file)


class CheckErrors(Exception):
    """The check found errors."""


def check(file: Path) -> None:
    if fmucheck.check(file, run=False).count(fmucheck.Severity.ERROR):
        raise CheckErrors


def libraries() -> list[bytes]:
    code = '__attribute__((visibility("default"))) double twice(double x) { return x + x; }\n'
    each = {
        name: toolchain.shared_library(
            "twice", {"a.c": code}, platform=platform, standalone=True
        ).read_bytes()
        for name, platform in toolchain.PLATFORMS.items()
    }
    return [*each.values(), universal([data for name, data in each.items() if "darwin" in name])]


def mat_files() -> list[bytes]:
    t = np.arange(30) * 1e-3
    log = {"t": t, "x": np.sin(t)[:, None], "kp": 3.0}
    kinds = {
        "s": {"t": t, "inner": {"x": t, "deep": {"y": t.astype(np.float32)}}},
        "cells": np.array(["a", 1], dtype=object),
        "z": t * 1j,
        "cube": np.zeros((2, 2, 2), np.uint8),
        "none": np.zeros((0, 3)),
    }
    found = []
    for content, compressed in ((log, False), (log, True), (kinds, False)):
        stream = io.BytesIO()
        scipy.io.savemat(stream, content, do_compression=compressed)
        found.append(stream.getvalue())
    return found


def parquet_files() -> list[bytes]:
    t = np.arange(64) * 1e-3
    plain = {"time": t, "x": np.sin(9 * t), "n": np.arange(64) % 3}
    found = []
    for how in (
        {"compression": "none", "use_dictionary": False},
        {"compression": "zstd", "row_group_size": 20, "data_page_version": "2.0"},
        {"compression": "gzip", "use_dictionary": ["n"], "write_statistics": False},
    ):
        stream = io.BytesIO()
        pq.write_table(pa.table(plain), stream, **how)
        found.append(stream.getvalue())
    return found


def read_parquet(file: Path) -> None:
    try:
        read_table(file)
    finally:
        cosim.read_tables(file)


PARSERS = {
    "csv": Parser("in.csv", cosim.read_tables, lambda: TABLES, by_words, (cosim.SignalError,)),
    "log_csv": Parser("log.csv", read_log, logs, by_words, (StickslipError,)),
    "fleet": Parser("fleet.csv", read_fleet, lambda: FLEETS, by_words, (UsageError,)),
    "config": Parser(
        "log.toml", load_description, lambda: [TOML.encode()], by_words, (UsageError,)
    ),
    "learned": Parser("learned.json", read_learned, learned_files, by_words, (UsageError,)),
    "checkpoint": Parser(
        "run.json",
        lambda file: _algorithm().replay(checkpoint.read(file, "")),
        checkpoints,
        by_words,
        (ga.StateError,),
    ),
    "ssp": Parser("system.ssp", read_package, system_packages, by_member, (cosim.CosimError,)),
    "state": Parser("half.state", Checkpoint.read, states, by_member, (cosim.SimulationError,)),
    "check": Parser(
        "a.fmu",
        check,
        lambda: [_zipped(reference.members(version)) for version in (2, 3)],
        by_member,
        (CheckErrors,),
    ),
    "description": Parser(
        "modelDescription.xml",
        lambda file: read_description(parse_xml(file.read_bytes())),
        lambda: [reference.members(version)["modelDescription.xml"] for version in (2, 3)],
        by_words,
        (Malformed, DescriptionFault),
    ),
    "library": Parser(
        "library",
        lambda file: read_library(file.read_bytes()),
        libraries,
        by_numbers,
        (NotALibrary,),
    ),
    "mat": Parser("log.mat", read_table, mat_files, by_numbers, (RecordingError,)),
    "parquet": Parser(
        "in.parquet", read_parquet, parquet_files, by_numbers, (cosim.SignalError, RecordingError)
    ),
}
SLOW = 2.0  # s of the processor for one input


@dataclass
class Tally:
    """What came of the inputs; ``unexpected`` and ``slow`` should stay empty."""

    accepted: int = 0
    refused: int = 0
    unexpected: list[str] = field(default_factory=list)
    slow: list[str] = field(default_factory=list)


def run(parser: Parser, seed: int, inputs: range, found: Path | None = None) -> Tally:
    """Read inputs; ``found`` is the folder for those that end otherwise than they should."""
    tally = Tally()
    with tempfile.TemporaryDirectory() as folder:
        for i in inputs:
            data, file = parser.made(seed, i), Path(folder) / parser.file
            file.write_bytes(data)
            begin, so_far = time.process_time(), len(tally.unexpected) + len(tally.slow)
            try:
                parser.read(file)
                tally.accepted += 1
            except parser.expected:
                tally.refused += 1
            except (Exception, RecursionError) as fault:  # noqa: BLE001 - what is looked for
                place = traceback.extract_tb(fault.__traceback__)[-1]
                where = f"{Path(place.filename).name}:{place.lineno}"
                tally.unexpected.append(f"{i}: {type(fault).__name__} at {where}: {fault}")
            if (seconds := time.process_time() - begin) > SLOW:
                tally.slow.append(f"{i}: {seconds:.1f} s")
            if found and len(tally.unexpected) + len(tally.slow) > so_far:
                (found / f"{i}.bin").write_bytes(data)
    return tally


ROUND, HANG = 1000, 600.0
"""Inputs, and the seconds for them after which the process ends with a traceback."""


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    options.add_argument("--parser", choices=sorted(PARSERS), required=True)
    options.add_argument("--inputs", type=int, default=1_000_000)
    options.add_argument("--first", type=int, default=0)
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / "fuzz")
    given = options.parse_args()
    found = given.out / f"{given.parser}-{given.seed}"
    found.mkdir(parents=True, exist_ok=True)
    faulthandler.enable()
    logging.disable()  # warnings about odd inputs are not what is looked for
    end = given.first + given.inputs
    for first in range(given.first, end, ROUND):
        faulthandler.dump_traceback_later(HANG, exit=True)
        tally = run(PARSERS[given.parser], given.seed, range(first, min(first + ROUND, end)), found)
        print(f"{first}: {tally}", flush=True)


if __name__ == "__main__":
    main()
