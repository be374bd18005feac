"""The C loops of loops.c over the ring's FMUs."""

import ctypes
from pathlib import Path

import numpy as np

from benchmarks.coupling import ring
from stickslip.fmi import toolchain
from tests.corpus.fmu import headers

_CALLS = ("DoStep", "Reset", "EnterInitializationMode", "ExitInitializationMode")


class Loops:
    """The functions of loops.c for one FMI version."""

    def __init__(self, version: int, library: Path | None = None) -> None:
        self._library = ctypes.CDLL(str(library or compiled(version)))
        self._fmus = [_Fmu(name, version) for name in ring.MODELS]
        table = [address for fmu in self._fmus for address in fmu.table]
        self._library.use((ctypes.c_void_p * len(table))(*table))
        self._library.candidate.restype = ctypes.c_double

    def plain(self, n: int) -> np.ndarray:
        """Return u, v, x, f after each step."""
        return self._run(self._library.plain, n)

    def in_turn(self, n: int) -> np.ndarray:
        """Return the same in Gauss-Seidel order."""
        return self._run(self._library.in_turn, n)

    def calls_in_turn(self, n: int) -> None:
        """Make the calls of a step in Gauss-Seidel order and nothing else."""
        self._run(self._library.calls_in_turn, n)

    def fused(self, n: int) -> np.ndarray:
        return self._run(self._library.fused, n)

    def candidate(self, n: int, K_p: float, K_i: float, *, turns: bool = False) -> float:
        numbers = (ctypes.c_double(value) for value in (ring.STEP, K_p, K_i))
        return self._library.candidate(ctypes.c_long(n), *numbers, ctypes.c_bool(turns))

    def _run(self, loop, n: int) -> np.ndarray:
        kept = np.empty((n, 4))
        address = ctypes.c_void_p(kept.ctypes.data)
        if loop(ctypes.c_long(n), ctypes.c_double(ring.STEP), address):
            raise RuntimeError("an FMU of the ring failed")
        return kept


def sources() -> dict[str, str]:
    files = {file: (ring.HERE / file).read_text() for file in ("ring.h", "loops.c")}
    return headers() | files


def compiled(version: int) -> Path:
    return toolchain.shared_library("loops", sources(), flags=(f"-DFMI={version}",))


class _Fmu:
    def __init__(self, name: str, version: int) -> None:
        library = ctypes.CDLL(str(ring.library(name)))
        kind = "Real" if version == 2 else "Float64"
        first, get, *rest = f"Set{kind}", f"Get{kind}", *_CALLS
        calls = [first, rest[0], get, *rest[1:]]
        make = getattr(
            library, "fmi2Instantiate" if version == 2 else "fmi3InstantiateCoSimulation"
        )
        make.restype = ctypes.c_void_p
        nothing = (None,) * (7 if version == 2 else 12)
        functions = (getattr(library, f"fmi{version}{call}") for call in calls)
        addresses = (ctypes.cast(function, ctypes.c_void_p).value for function in functions)
        self.table = [make(*nothing), *addresses]
