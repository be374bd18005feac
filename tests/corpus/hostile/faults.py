"""The FMU of ``faults.c``, which fails where it is told to."""

from functools import cache
from pathlib import Path
from typing import Literal

from tests.corpus import fmu
from tests.corpus.fmu import Variable

Kind = Literal["plain", "typed", "exchange", "events"]
"""Co-Simulation with doubles alone, or an integer as well; Model Exchange; event mode (FMI 3.0)."""

ARMED_ELSEWHERE = "armed elsewhere"
_FLAGS = ("-Wno-unused-parameter", "-Wno-variadic-macro-arguments-omitted", "-Wno-pedantic")
_VARIABLES = [
    Variable("u", "input", 0),
    Variable("y", "output", depends=()),
    Variable("x"),
    Variable("der(x)", derivative="x"),
    Variable("k", "parameter", 1),
    Variable("n", "output", type="Int32", depends=()),
]


@cache
def library() -> bytes:
    """Return the compiled FMU, one for all versions and kinds."""
    source = Path(__file__).with_name("faults.c")
    return fmu.library("faults", source, flags=_FLAGS).read_bytes()


def write(path: Path, plan: str, version: int = 2, kind: Kind = "plain") -> Path:
    """Write an FMU that fails as planned: ``FUNCTION NTH STATUS``, or ARMED_ELSEWHERE.

    A number behind them is of the environment that it passes to the logger, see faults.c.
    """
    word = "state" if version == 2 else "State"
    flags = f'canGetAndSetFMU{word}="true" canSerializeFMU{word}="true"'
    if kind == "exchange":
        interfaces = {"ModelExchange": f'{flags} needsCompletedIntegratorStep="true"'}
    else:
        flags += ' canHandleVariableCommunicationStepSize="true"'
        flags += ' hasEventMode="true"' if kind == "events" and version == 3 else ""
        interfaces = {"CoSimulation": flags}
    description = fmu.describe(
        "faults",
        version,
        _VARIABLES if kind == "typed" else _VARIABLES[:-1],
        interfaces,
        token=plan,
        experiment='startTime="0" stopTime="1" stepSize="0.1"',
    )
    return fmu.pack(path, description, {fmu.place("faults", version): library()})
