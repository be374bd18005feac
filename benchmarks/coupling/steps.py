"""What a step of the ring costs, and one candidate, relative to the plain C loop."""

import shutil
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np

from benchmarks.coupling import ring
from benchmarks.coupling.loops import Loops, sources
from benchmarks.coupling.peers import PEERS
from benchmarks.timing import interleaved
from stickslip import cosim

N = 100_000  # steps
CANDIDATE = 10_000
PLAIN = "plain C loop over FMI pointers, all recorded"
IN_TURN = "plain C loop, Gauss-Seidel"
CANDIDATE_LOOP = "C loop with reset"
CANDIDATE_IN_TURN = "C loop with reset, Gauss-Seidel"


def measure(folder: Path, version: int) -> dict[str, float]:
    """Return the seconds of N steps by who steps them."""
    loops = Loops(version)
    system = ring.system(folder, version)
    cases: dict[str, Callable[[], object]] = {
        "fused C loop, no FMI": lambda: loops.fused(N),
        PLAIN: lambda: loops.plain(N),
        IN_TURN: lambda: loops.in_turn(N),
        "calls alone, Gauss-Seidel": lambda: loops.calls_in_turn(N),
    }
    if gcc := _with_gcc(folder, version):
        cases["plain C loop, by gcc"] = lambda: gcc.plain(N)
        cases["plain C loop, by gcc, Gauss-Seidel"] = lambda: gcc.in_turn(N)
    for name, options in {
        "cosim, Jacobi": {"coupling": "jacobi"},
        "cosim, Jacobi, two signals recorded": {"coupling": "jacobi", "record": ["mass.*"]},
        "cosim, Gauss-Seidel": {},
        "cosim, Gauss-Seidel, two signals recorded": {"record": ["mass.*"]},
    }.items():
        for compiled in (False, True):
            simulation = _prepare(system, N, compiled=compiled, **options)
            cases[name + ", compiled" * compiled] = simulation.run
    np.testing.assert_array_equal(loops.plain(N), cases["cosim, Jacobi"]().values[1:])
    np.testing.assert_array_equal(loops.in_turn(N), cases["cosim, Gauss-Seidel"]().values[1:])
    return interleaved(cases, 21, time.thread_time)


def measure_candidate(folder: Path, version: int) -> dict[str, float]:
    """Return the seconds of one candidate: reset, set two parameters, run, read the cost."""
    loops = Loops(version)
    gains = {"controller.K_p": 41.0, "controller.K_i": 910.0}
    system = ring.system(folder, version)
    error = cosim.Deviation("mass.v", 0.2, begin=ring.STEP)
    records = {
        "": cosim.Record(sum_of_squares={"cost": error}),
        ", cost in NumPy": cosim.Record("mass.v"),
    }

    def cost_of(simulation) -> float:
        result = simulation.run(gains)
        if result.sum_of_squares:
            return result.sum_of_squares["cost"]
        error = 0.2 - result["mass.v"][1:]
        return float(error @ error)

    cases: dict[str, Callable[[], float]] = {
        CANDIDATE_LOOP: lambda: loops.candidate(CANDIDATE, *gains.values()),
        CANDIDATE_IN_TURN: lambda: loops.candidate(CANDIDATE, *gains.values(), turns=True),
    }
    if gcc := _with_gcc(folder, version):
        for order, turns in ("", False), (", Gauss-Seidel", True):
            cases[f"{CANDIDATE_LOOP}, by gcc{order}"] = lambda turns=turns: gcc.candidate(
                CANDIDATE, *gains.values(), turns=turns
            )
    for name, record in records.items():
        for coupling, order in (("jacobi", ""), ("gauss_seidel", ", Gauss-Seidel")):
            for compiled in (False, True):
                simulation = _prepare(
                    system, CANDIDATE, coupling=coupling, record=record, compiled=compiled
                )
                case = "cosim" + order + name + ", compiled" * compiled
                cases[case] = lambda s=simulation: cost_of(s)
    for name, case in cases.items():
        loop = CANDIDATE_IN_TURN if "Gauss-Seidel" in name else CANDIDATE_LOOP
        np.testing.assert_allclose(case(), cases[loop](), rtol=1e-12)
    return interleaved(cases, 201, time.thread_time)


def measure_peers(folder: Path) -> dict[str, float]:
    """Return the seconds of N steps of every peer that is installed."""
    seconds = {}
    for name, (run, n) in PEERS.items():
        try:
            seconds[name] = np.median([run(folder, n) for _ in range(5)]) * N / n
        except (ImportError, OSError, RuntimeError) as reason:
            print(f"  {name}: left out: {reason}")
    return seconds


def _prepare(system, steps: int, **options):
    return system.prepare(step=ring.STEP, stop=steps * ring.STEP, constant_step=True, **options)


def _with_gcc(folder: Path, version: int) -> Loops | None:
    if not (gcc := shutil.which("gcc")):
        print("  gcc: left out: not installed")
        return None
    path = folder / f"gcc{version}.so"
    for name, text in sources().items():
        if name.endswith(("loops.c", "ring.h")):
            (folder / name).write_text(text)
    headers = Path(fmpy.__file__).parent / "c-code"
    command = [gcc, "-O2", "-fPIC", "-shared", f"-DFMI={version}", f"-I{headers}"]
    subprocess.run([*command, str(folder / "loops.c"), "-o", str(path)], check=True)
    return Loops(version, path)
