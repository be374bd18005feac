"""``fleet TABLE.csv``."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from random import Random
from unittest import mock

from stickslip import models
from stickslip.errors import UsageError
from stickslip.fleet import read_fleet
from tests.corpus.fuzz.tokens import by_tokens

_load = cache(models.load_model)  # which does not depend on the input
EXPECTED = (UsageError,)
_WORDS = (
    *(b",", b"\n", b"\r", b'"', b"'", b"\\", b"=", b"drive.", b"F_c", b"m", b"noise", b"on"),
    *(b"name", b"log", b"config", b"set", b"\0", b"a.csv", b"../x", b"sigma_0", b"#", b" "),
)


def corpus() -> list[bytes]:
    return [
        b"name,log,config\na,a.csv,a.toml\nb,sub/b.mat,\n",
        b'\xef\xbb\xbfname,set\r\nx,"drive.m=10 drive.noise=on"\r\ny,drive.F_c=5\r\n',
        b"name,log,set\na,a.csv,\nb,,drive.b=20 drive.sigma_0=1e6\n",
    ]


def parse(data: bytes, folder: Path) -> None:
    file = folder / "fleet.csv"
    file.write_bytes(data)
    with mock.patch("stickslip.models.load_model", _load):
        read_fleet(file)


def mutate(rng: Random, data: bytes) -> bytes:
    return by_tokens(rng, data, _WORDS)
