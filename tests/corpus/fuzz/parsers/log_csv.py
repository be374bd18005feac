"""``learn --log LOG.csv``: any dialect of text, up to the even grid."""

from __future__ import annotations

import math
from pathlib import Path
from random import Random

from stickslip.errors import StickslipError
from stickslip.logs import Description, raise_errors
from stickslip.pipeline.log_learning import read_and_check
from tests.corpus.fuzz.tokens import by_tokens

EXPECTED = (StickslipError,)
_WORDS = (
    *(b",", b";", b"\t", b" ", b"|", b'"', b"\n", b"\r", b"#", b"%", b"[mm]", b"(deg)", b"/ s"),
    *(b"time", b"position", b"x", b"F", b"velocity", b"torque", b"2026-01-31T10:00:00.125", b"nan"),
    *(b"ms", b"counts", b"A", b"rpm", b"\xff\xfe", b"\xe4"),
)


def _rows(mark: str, end: str = "\n", point: str = ".") -> str:
    rows = (
        mark.join(f"{number:.9g}" for number in (k * 1e-2, math.sin(k / 9), math.cos(k / 9)))
        for k in range(60)
    )
    return end.join(rows).replace(".", point) + end


def corpus() -> list[bytes]:
    dated = "".join(f"2026-01-31T10:00:00.{k:03d},{k * k / 8e3},{-k / 8}\n" for k in range(30))
    return [
        f"t,x,F\n{_rows(',')}".encode(),
        f"Zeit;Position;Kraft\r\ns;mm;N\r\n{_rows(';', chr(13) + chr(10), ',')}".encode("latin-1"),
        f"# a log\n# of a drive\ntime [ms]\tposition [deg]\ttorque [Nm]\n{_rows(chr(9))}".encode(),
        f"time position force\n{_rows('  ')}".encode("utf-16"),
        f"timestamp,position,force\n{dated}".encode(),
        _rows(" ").encode(),
    ]


def parse(data: bytes, folder: Path) -> None:
    file = folder / "log.csv"
    file.write_bytes(data)
    raise_errors(file, read_and_check(file, Description())[1])


def mutate(rng: Random, data: bytes) -> bytes:
    return by_tokens(rng, data, _WORDS)
