"""``simulate --input TABLE.csv``."""

from __future__ import annotations

from pathlib import Path
from random import Random

from stickslip import cosim
from tests.corpus.fuzz.tokens import by_tokens

EXPECTED = (cosim.SignalError,)
_WORDS = (
    b"time",
    b"u",
    b",",
    b";",
    b"\t",
    b'"',
    b"\n",
    b"\r",
    b"\r\n",
    b'""',
    b"\0",
    b"# ",
    b"\n\n",
)


def corpus() -> list[bytes]:
    return [
        b"time,u\n0,0\n0.5,1e-3\n1,2\n",
        b'\xef\xbb\xbf"time","a b",c\r\n0,1,2\r\n0,3,4\r\n1.5,-1,.5\r\n',
        b"u,time\n1,0\n",
        b"time,x[1],x[2],flag\n" + b"".join(b"%d,%d,0.1,1\n" % (k, k % 7) for k in range(40)),
    ]


def parse(data: bytes, folder: Path) -> None:
    file = folder / "in.csv"
    file.write_bytes(data)
    cosim.read_tables(file)


def mutate(rng: Random, data: bytes) -> bytes:
    return by_tokens(rng, data, _WORDS)
