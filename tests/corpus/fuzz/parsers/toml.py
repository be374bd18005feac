"""``--config LOG.toml`` and ``export lti SYSTEM.toml``."""

from __future__ import annotations

from pathlib import Path
from random import Random

from stickslip.errors import UsageError
from stickslip.logs import load_description
from stickslip.models.errors import LtiError
from stickslip.models.lti.file import read_lti
from tests.corpus.fuzz.tokens import by_tokens

EXPECTED = (UsageError, LtiError)
_WORDS = (
    *(b"[", b"]", b"{", b"}", b"=", b".", b'"', b"'", b'"""', b"\n", b"#", b",", b"\\u0000"),
    *(b"columns", b"controller", b"motion", b"span", b"name", b"index", b"scale", b"true", b"nan"),
    *(b"1979-05-27T07:32:00Z", b"0x7f", b"-inf", b"[[a]]", b"a.b", b'"\\ud800"', b"A", b"B", b"D"),
    *(b"num", b"den", b"x0", b"inputs", b"[" * 2000, b"a." * 200, b"{a=" * 500),
)


def corpus() -> list[bytes]:
    return [
        b"""motion = "rotary"
encoder_step = 1e-6
force_limit = "2*kt"
sample_period = 0.001
span = [0.5, 20]
tau_i = 0
delimiter = ";"
decimal = ","
[columns]
time = "t"
position = {name = "x", unit = "mm"}
velocity = 3
[columns.force]
name = "i"
unit = "A"
scale = "kt*2"
offset = -0.1
[controller]
kind = "cascade"
K_x = 10
K_p = 3.5
K_i = "ki"
""",
        b'name = "s"\nA = [[0, 1], [-2, -3]]\nB = [[0], [1]]\nC = [[1, 0]]\nD = [[0]]\n'
        b'dt = 0.001\nx0 = [0, 1]\nstep = 0.01\nstop = 2\nstates = ["x", "v"]\n'
        b'[inputs]\nu = "N"\n[outputs]\ny = "m"\n',
        b"num = [1]\nden = [1, 0.5, 2.5]\n",
        b"num = [[[1], [2]], [[3], [4]]]\nden = [[[1, 1], [1, 2]], [[1, 3], [1, 4]]]\n",
    ]


def parse(data: bytes, folder: Path) -> None:
    file = folder / "in.toml"
    file.write_bytes(data)
    (read_lti if b"num" in data or b"D =" in data else load_description)(file)


def mutate(rng: Random, data: bytes) -> bytes:
    return by_tokens(rng, data, _WORDS)
