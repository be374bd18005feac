"""A step of the compensator as exported C, in exponentials of the C library."""

import ctypes
from pathlib import Path

from benchmarks.timing import interleaved
from stickslip.fmi import toolchain
from stickslip.models.firmware import write_compensator

N = 200_000


def measure(folder: Path) -> dict[str, float]:
    files = {path.name: path.read_text() for path in write_compensator(folder, "c")}
    files["firmware.c"] = Path(__file__).with_name("firmware.c").read_text()
    cases = {}
    for name, define in (("double", ()), ("float", ("-DCOMPENSATOR_FLOAT",))):
        flags = ("-Wno-conversion", "-lm", *define)
        library = ctypes.CDLL(str(toolchain.shared_library("firmware", files, flags=flags)))
        cases[name] = lambda lib=library: lib.steps(ctypes.c_size_t(N))
        cases["exp"] = lambda lib=library: lib.exponentials(ctypes.c_size_t(N))
    taken = interleaved(cases, 15)
    return {f"step in {name} / exp": taken[name] / taken["exp"] for name in ("double", "float")}
