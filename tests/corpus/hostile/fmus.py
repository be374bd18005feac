"""FMUs that misbehave as they are told, all of one library."""

from functools import cache
from pathlib import Path

from tests.corpus import fmu
from tests.corpus.fmu import Variable

_VARIABLES = [
    Variable("u", "input", 1.0),
    Variable("y", "output", 0.0, initial="exact", depends=()),
    Variable("k", "parameter", 1.0),
    Variable("fragile", "parameter", 0.0),
]


@cache
def library() -> bytes:
    """Return the library of hostile.c."""
    flags = ("-Wno-infinite-recursion", "-Wno-null-dereference", "-lpthread", "-ldl", "-lm")
    source = Path(__file__).with_name("hostile.c")
    return fmu.library("hostile", source, flags=flags).read_bytes()


def write(
    path: Path,
    behaviour: str = "",
    *,
    version: int = 2,
    token: str = "hostile",  # noqa: S107 - that of FMI
    binaries: dict[str, bytes] | None = None,
    flags: str = "",
) -> Path:
    """Write an FMU that misbehaves: call, what it does, at which time, such as ``DoStep segv 3``.

    Binaries are by their names in the archive, flags further attributes of the interface.
    """
    description = fmu.describe(
        "hostile",
        version,
        _VARIABLES,
        {"CoSimulation": f'canHandleVariableCommunicationStepSize="true" {flags}'},
        token=token,
        experiment='startTime="0" stopTime="0.1" stepSize="0.01"',
    )
    files = {place(version): library()} if binaries is None else binaries
    return fmu.pack(path, description, {"resources/behaviour.txt": behaviour.encode(), **files})


def place(version: int = 2, name: str = "hostile") -> str:
    """Return where a library for this machine lies."""
    return fmu.place(name, version)
