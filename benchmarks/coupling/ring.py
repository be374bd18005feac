"""The ring: three FMUs of a few operations each, or three times as many; C loops over them."""

import ctypes
from functools import partialmethod
from pathlib import Path

import numpy as np

from stickslip import cosim
from stickslip.fmi import toolchain
from tests.corpus import fmu
from tests.corpus.fmu import headers

HERE = Path(__file__).parent
STEP = 1e-4
MODELS = {
    "controller": ["y input 0", "u output 0", "I local 0", "r parameter 0.2",
                   "K_p parameter 40", "K_i parameter 900"],
    "mass": ["u input 0", "f input 0", "v output 0", "x output 0", "m parameter 2",
             "d parameter 0.1"],
    "friction": ["v input 0", "f output 0", "c parameter 1.5", "z local 0"],
}  # fmt: skip
FEEDS = {"controller.u": "mass.u", "friction.f": "mass.f", "mass.v": ("controller.y", "friction.v")}


def system(folder: Path, version: int, n: int = 3, extra: int = 0) -> cosim.System:
    """Return a ring of n FMUs, n / 3 times the three models; ``extra`` outputs each, FMI 2.0."""
    fmus = {name: cosim.Fmu(build(folder, name, version, extra)) for name in MODELS}
    ring = cosim.System("ring")
    for i in range(n // 3):
        for name in MODELS:
            ring.add(_component(name, i), fmus[name])
    for i in range(n // 3):
        ring.connect(_component("controller", i, "u"), _component("mass", i, "u"))
        ring.connect(_component("friction", i, "f"), _component("mass", i, "f"))
        ring.connect(_component("mass", i, "v"), _component("friction", i, "v"))
        after = (i + 1) % (n // 3)
        ring.connect(_component("mass", i, "v"), _component("controller", after, "y"))
    return ring


def build(folder: Path, name: str, version: int, extra: int = 0) -> Path:
    """Write one FMU of FMI 2.0 or 3.0."""
    path = folder / f"fmi{version}-{extra}" / f"{name}.fmu"
    if not path.exists():
        binary = library(name).read_bytes()
        fmu.pack(path, _description(name, version, extra), {fmu.place(name, version): binary})
    return path


def library(name: str) -> Path:
    """Compile one model."""
    flags = (f"-DMODEL_START={name.upper()}_START", f"-DMODEL_STEP=step_{name}")
    return fmu.library(name, HERE / "ring.h", HERE / "ring.c", flags=flags)


def _component(name: str, i: int, variable: str | None = None) -> str:
    component = f"{name}{i}" if i else name
    return f"{component}.{variable}" if variable else component


def _description(name: str, version: int, extra: int) -> str:
    listed = [line.split() for line in MODELS[name]]
    source = next(i for i, (_, kind, _) in enumerate(listed) if kind == "output")
    entries = [(i, *entry) for i, entry in enumerate(listed)]
    entries += [
        (source if version == 2 else fmu.TIME + 1 + i, f"copy[{i}]", "output", "0")
        for i in range(extra)
    ]
    variables = [
        fmu.Variable(
            variable,
            kind,
            start,
            variability="tunable" if kind == "parameter" else "continuous",
            initial=None if kind == "input" else "exact",
            reference=reference,
            depends=() if kind == "output" else None,
        )
        for reference, variable, kind, start in entries
    ]
    ability = 'canHandleVariableCommunicationStepSize="true"'
    return fmu.describe(name, version, variables, {"CoSimulation": ability})


_CALLS = ("DoStep", "Reset", "EnterInitializationMode", "ExitInitializationMode")


class Loops:
    """The functions of loops.c for one FMI version."""

    def __init__(self, version: int) -> None:
        files = {file: (HERE / file).read_text() for file in ("ring.h", "loops.c")} | headers()
        library = toolchain.shared_library("loops", files, flags=(f"-DFMI={version}",))
        self._library = ctypes.CDLL(str(library))
        self._fmus = [_Fmu(name, version) for name in MODELS]
        table = [address for fmu in self._fmus for address in fmu.table]
        self._library.use((ctypes.c_void_p * len(table))(*table))
        self._library.candidate.restype = ctypes.c_double

    def candidate(self, n: int, K_p: float, K_i: float, *, turns: bool = False) -> float:
        numbers = (ctypes.c_double(value) for value in (STEP, K_p, K_i))
        return self._library.candidate(ctypes.c_long(n), *numbers, ctypes.c_bool(turns))

    def _run(self, loop: str, n: int) -> np.ndarray:
        kept = np.empty((n, 4))
        address = ctypes.c_void_p(kept.ctypes.data)
        if self._library[loop](ctypes.c_long(n), ctypes.c_double(STEP), address):
            raise RuntimeError("an FMU of the ring failed")
        return kept

    plain = partialmethod(_run, "plain")  # u, v, x, f after each step
    in_turn = partialmethod(_run, "in_turn")  # the same in Gauss-Seidel order
    calls_in_turn = partialmethod(_run, "calls_in_turn")  # the calls of such a step alone
    fused = partialmethod(_run, "fused")


class _Fmu:
    def __init__(self, name: str, version: int) -> None:
        loaded = ctypes.CDLL(str(library(name)))
        kind = "Real" if version == 2 else "Float64"
        first, get, *rest = f"Set{kind}", f"Get{kind}", *_CALLS
        calls = [first, rest[0], get, *rest[1:]]
        make = getattr(loaded, "fmi2Instantiate" if version == 2 else "fmi3InstantiateCoSimulation")
        make.restype = ctypes.c_void_p
        nothing = (None,) * (7 if version == 2 else 12)
        functions = (getattr(loaded, f"fmi{version}{call}") for call in calls)
        addresses = (ctypes.cast(function, ctypes.c_void_p).value for function in functions)
        self.table = [make(*nothing), *addresses]
