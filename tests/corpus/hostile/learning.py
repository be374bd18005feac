"""What learning starts from, goes on with and leaves behind, damaged."""

import json
import zipfile
from io import BytesIO
from pathlib import Path
from typing import Any

from tests.corpus.hostile.case import Case, family
from tests.corpus.hostile.sound import sound

LEARNED = Path(__file__).parents[3] / "results" / "paper" / "learned.json"


_learned = family(
    23, "learned", "{} --parameters learned.json", file="learned.json", begins="learned.json: .*"
)
_set = family(23, "set", "reproduce --out out --set")
_fleet = family(23, "fleet", "fleet fleet.csv --out out", file="fleet.csv", begins="fleet.csv: .*")
_plan = family(23, "plan", "plan")
_state = family(23, "state", "simulate a.fmu --resume half.state", file="half.state", a_fmu=sound)
_EXPORT = "export compensator"


def changed(*path: str, to: Any) -> bytes:
    """Return the paper's learned.json with another value somewhere."""
    document = json.loads(LEARNED.read_bytes())
    part = document
    for key in path[:-1]:
        part = part[key]
    part[path[-1]] = to
    return json.dumps(document).encode()


def _zip(**members: bytes) -> bytes:
    stream = BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return stream.getvalue()


_VALUE = ("parameters", "F_c", "value")
DOCUMENTS = [
    _learned("syntax", "JSON that is cut off", "(Expecting|Unterminated)", LEARNED.read_bytes()[:99], _EXPORT),
    _learned("infinite", "a parameter 1e999", "each with a finite value", changed(*_VALUE, to=12345.5).replace(b"12345.5", b"1e999"), _EXPORT),
    _learned("negative", "a parameter below its range", "F_c = -1 N is outside", changed(*_VALUE, to=-1.0), _EXPORT),
    _learned("loop", "a loop without its gains", "loop: .*is missing", changed("loop", to={"m": {"value": 5.0}}), _EXPORT),
    _learned("loop-unstable", "a loop that is not stable", "unstable", changed("loop", "K_p", to={"value": -1e9}), _EXPORT),
    _learned("loop-period", "a sample period of 0", "T_s is 0 s", changed("loop", "T_s", to={"value": 0.0}), _EXPORT),
    _learned("validation-long", "a command of 1e300 s", "samples", changed("validation", "plateau", to={"value": 1e300}), _EXPORT),
]  # fmt: skip

OPTIONS = [
    _set("text", "a mass that is text", "must be a number", "drive.m=heavy"),
    _set("twice", "two masses", "set twice", "drive.m=1 drive.m=2"),
    _set("no-assignment", "a name alone", "expected NAME=VALUE", "drive.m"),
    _set("component", "a parameter of something else", "only the drive's", "stage.m=1"),
    Case(23, "seed-negative", "a negative seed", "--seed: expected a whole number, at least 0", "reproduce --out out --seed -1"),
    _plan("duration", "an experiment without end", "duration", "--duration inf"),
    _plan("parameter", "a parameter that is none", "'q'", "--show q"),
]  # fmt: skip

FLEETS = [
    _fleet("empty", "an empty table", "expected columns", b""),
    _fleet("column", "a column that is none", "row 1: .*got 'logg'", b"name,logg\na,b\n"),
    _fleet("ragged", "a row that is too long", "row 2: expected 2 cells", b"name,log\na,b,c\n"),
    _fleet("name", "a name that is a path", "row 2, column name", b"name,log\n../a,b\n"),
    _fleet("twice", "two drives of one name", "is there already", b"name,log\na,b\nA,c\n"),
    _fleet("log", "a drive without a log", "row 2, column log", b"name,log\na,\n"),
    _fleet("binary", "bytes that are no text", "not a CSV file in UTF-8", bytes(range(256))),
]  # fmt: skip

STATES = [
    _state("text", "a saved state that is text", "no saved state", b"hello"),
    _state("empty", "a saved state that holds nothing", "no saved state", _zip()),
    _state("pickle", "a saved state with Python objects", "holds what was not saved here", _zip(row=b"\x93NUMPY\1\0v\0{'descr': '|O', 'fortran_order': False, 'shape': (1,), }\n")),
    _state("code", "a saved state whose header is an expression", "holds what was not saved here", _zip(row=b"\x93NUMPY\1\0v\0" + b"(" * 5000)),
]  # fmt: skip

CASES = [*DOCUMENTS, *OPTIONS, *FLEETS, *STATES]
