"""Tables of inputs, logs and their descriptions that hold something else than they should."""

import io
import os
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from tests.corpus.hostile.case import family
from tests.corpus.hostile.sound import sound
from tests.corpus.hostile.zips import DEFLATE, Member, zipped


def _recorded() -> bytes:
    """Return a log of 5 kg, 20 N s/m and 6 N of friction on a sine."""
    t = np.arange(600) * 1e-3
    x, v, a = (0.05 * 15.0**k * np.sin(15.0 * t + k * np.pi / 2) for k in range(3))
    force = 5.0 * a + 20.0 * v + 6.0 * np.sign(v)
    rows = (f"{row[0]:.3f},{row[1]:.9f},{row[2]:.6f}" for row in zip(t, x, force, strict=True))
    return "\n".join(("t,x,F", *rows, "")).encode()


LOG = _recorded()


_input = family(22, "input", "simulate a.fmu --input in{}", file="in{}", a_fmu=sound)
_log = family(22, "log", "learn --log log{} --check", file="log{}")
_config = family(
    22, "config", "learn --log log.csv --config log.toml --check", file="log.toml", log_csv=LOG
)


def _rows(*rows: str, head: str = "time,u") -> bytes:
    return "\n".join((head, *rows, "")).encode()


def _changed(line: int, text: bytes) -> bytes:
    lines = LOG.split(b"\n")
    lines[line - 1] = text
    return b"\n".join(lines)


def _parquet(**columns: Any) -> bytes:
    stream = io.BytesIO()
    pq.write_table(pa.table(columns), stream)
    return stream.getvalue()


def _repeated() -> bytes:
    """Return a Parquet file of a few thousand bytes that holds 110 million numbers."""
    stream = io.BytesIO()
    zeros = pa.chunked_array([pa.array(np.zeros(10_000_000, bool))] * 11)
    pq.write_table(pa.table({"time": zeros}), stream, compression="zstd", row_group_size=2**27)
    return stream.getvalue()


def _mat(*elements: tuple[int, bytes]) -> bytes:
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x0100) + b"IM"
    return head + b"".join(struct.pack("<II", kind, len(data)) + data for kind, data in elements)


def _matrix(name: bytes, content: bytes, shape: tuple[int, ...], which: int = 6) -> bytes:
    def element(kind: int, data: bytes) -> bytes:
        return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)

    return (
        element(6, struct.pack("<II", which, 0))
        + element(5, struct.pack(f"<{len(shape)}i", *shape))
        + element(1, name)
        + element(9, content)
    )


def _bomb() -> bytes:
    """Return 320 MB of zeros, packed: one block over and over."""
    packer = zlib.compressobj(9)
    first = packer.compress(bytes(1 << 20)) + packer.flush(zlib.Z_FULL_FLUSH)
    again = packer.compress(bytes(1 << 20)) + packer.flush(zlib.Z_FULL_FLUSH)
    return first + again * 320 + packer.flush()


def _huge(path: Path) -> None:
    """Make a file of 4 GB that takes no room."""
    with path.open("wb") as file:
        file.write(LOG)
        file.truncate(1 << 32)


INPUTS = [
    _input("time-falls", "time that goes back", "line 4: time falls from 1.0 to 0.5 s", _rows("0,0", "1,1", "0.5,2")),
    _input("text", "text among numbers", "line 2: column 'u': .* got 'on'", _rows("0,on")),
    _input("ragged", "a row that is too short", "line 3: expected 2 cells, got 1", _rows("0,0", "1")),
    _input("semicolons", "semicolons between cells", "separated by commas, got 'time;u'", _rows("0;0", head="time;u")),
    _input("no-time", "no column time", "'time' among them", _rows("0,0", head="t,u")),
    _input("column-twice", "two columns of one name", "got 'u' twice", _rows("0,1,2", head="time,u,u")),
    _input("column-unknown", "a column that is no input", "no exposed input 'v'", _rows("0,1", head="time,v")),
    _input("held-unknown", "a held column that is not there", "cannot hold v", _rows("0,1"), ".csv", "--hold v"),
    _input("header-only", "names and no values", "no values below", b"time,u\n"),
    _input("empty", "an empty file", "'time' among them", b""),
    _input("nul", "NUL bytes", "in.csv", b"time,u\n0,\0\n"),
    _input("long-line", "a line of 3 MB", "line 2: 3000001 characters", lambda _: b"time,u\n" + b"1," * 1_500_000 + b"\n"),
    _input("open-quote", "a quote that never ends", "in.csv", b'time,u\n"' + b"0,1\n" * 60_000),
    _input("missing", "no file", "in.csv: cannot be read: No such file", None),
    _input("folder", "a folder", "in.csv: cannot be read: ", Path.mkdir),
    _input("pipe", "a pipe that nobody writes to", "no regular file", os.mkfifo),
    _input("parquet-as-csv", "a Parquet file called .csv", "not a CSV file in UTF-8", lambda _: _parquet(time=np.arange(99) / 7)),
    _input("csv-as-parquet", "a CSV file called .parquet", "in.parquet: cannot be read", _rows("0,0"), ".parquet"),
    _input("parquet-text", "texts in a Parquet file", "column 'u': expected numbers, got .*string", lambda _: _parquet(time=[0.0, 1.0], u=["a", "b"]), ".parquet"),
    _input("parquet-nulls", "empty cells in a Parquet file", "not finite", lambda _: _parquet(time=[0.0, 1.0], u=[None, 2.0]), ".parquet"),
    _input("parquet-cut", "half a Parquet file", "in.parquet: cannot be read", lambda _: _parquet(time=np.arange(99.0), u=np.arange(99.0))[:400], ".parquet"),
    _input("parquet-growth", "a small Parquet file of 110 million numbers", "at most 100000000 values", lambda _: _repeated(), ".parquet"),
]  # fmt: skip

LOGS = [
    _log("time-falls", "time that goes back", "row 40: time goes from 0.037 to 0 s", _changed(40, b"0,1,1")),
    _log("time-twice", "a time that comes twice", "row 40: the same time and position as", _changed(40, b"0.037,0.026347165,1")),
    _log("text", "text among numbers", "column 'x': row 7: expected a number, got 'abc'", _changed(7, b"0.005,abc,1")),
    _log("ragged", "a row that is too short", "row 9: expected 3 fields", _changed(9, b"0.007")),
    _log("no-motion", "no column of position or velocity", "no column of position or velocity", LOG.replace(b"t,x,F", b"t,a,F")),
    _log("empty", "an empty file", "empty; expected columns of numbers", b""),
    _log("long-line", "a line of 1 MB", "row 2: 1000000 characters", lambda _: b"t,x\n" + b"1;" * 500_000 + b"\n1,2\n"),
    _log("many-lines", "25 million lines", "25000000 lines; expected at most 20000000", lambda _: b"1\n" * 25_000_000),
    _log("brackets", "a name of brackets and blanks, slow to search", "no column of time", lambda _: b"( " * 30_000 + b",b\n" + b"1,2\n" * 50),
    _log("spreadsheet", "a spreadsheet", "an archive", b"PK\3\4" + bytes(30)),
    _log("missing", "no file", "log.csv: No such file", None),
    _log("pipe", "a pipe that nobody writes to", "no regular file", os.mkfifo),
    _log("huge", "4 GB", "4294967296 bytes, at most", _huge),
    _log("parquet-cut", "half a Parquet file", "not a Parquet file, or damaged", lambda _: _parquet(t=np.arange(99.0), x=np.arange(99.0))[:300], ".parquet"),
    _log("parquet-nested", "a position that is a list", "no column of position", lambda _: _parquet(t=np.arange(50.0), x=[[1.0]] * 50), ".parquet"),
    _log("mat-text", "a text called .mat", "a text, not a file of MAT", LOG, ".mat"),
    _log("mat-7.3", "a MAT file of version 7.3 without content", "cannot be read as HDF5 or MATLAB 7.3", b"MATLAB 7.3 MAT-file".ljust(512) + b"\x89HDF\r\n\x1a\n", ".mat"),
    _log("mat-cells", "cells instead of numbers", "cannot be read as MAT, perhaps it is damaged", lambda _: _mat((14, _matrix(b"x", b"", (3, 1), which=1))), ".mat"),
    _log("mat-bomb", "320 MB of zeros, packed", "cannot be read as MAT, perhaps it is damaged", lambda _: _mat((15, _bomb())), ".mat"),
    _log("excel-bomb", "a workbook of 300 MB, says its archive", "cannot be read as Excel.* 314572800 bytes unpacked", lambda _: zipped([Member(b"xl/workbook.xml", bytes(1 << 20), DEFLATE, size=300 << 20)]), ".xlsx"),
    _log("tdms-cut", "a TDMS file that ends in its header", "no vectors of numbers", b"TDSm" + bytes(3), ".tdms"),
    _log("mdf-cut", "an MF4 file that ends in its header", "cannot be read as MDF", b"MDF     4.10    " + bytes(48), ".mf4"),
    _log("mat-damaged", "packed data that is none", "cannot be read as MAT, perhaps it is damaged", lambda _: _mat((15, b"x" * 40)), ".mat"),
]  # fmt: skip

CONFIGS = [
    _config("syntax", "TOML without a value", "not TOML", b"motion =\n"),
    _config("twice", "a key that is there twice", "not TOML .*overwrite", b"tau_i = 1\ntau_i = 2\n"),
    _config("unknown", "a key that means nothing", "no key 'motionn'", b'motionn = "linear"\n'),
    _config("type", "a list where a number should be", "expected a number", b"tau_i = [1]\n"),
    _config("nan", "NaN where a number should be", "tau_i = nan", b"tau_i = nan\n"),
    _config("deep", "lists a hundred thousand deep", "nested too deeply", b"tau_i = " + b"[" * 100_000),
    _config("column", "a column that is not there", "no column 'q'", b'[columns]\nposition = "q"\n'),
    _config("unit", "a position in newtons", "position is in N", b'[columns.position]\nname = "x"\nunit = "N"\n'),
]  # fmt: skip

CASES = [*INPUTS, *LOGS, *CONFIGS]
