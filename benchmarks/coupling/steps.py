"""What a step of the ring costs, and one candidate, relative to the plain C loop."""

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks.common import interleaved
from benchmarks.coupling import ring
from benchmarks.coupling.ring import Loops
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

    def cost_of(simulation) -> float:
        error = 0.2 - simulation.run(gains)["mass.v"][1:]
        return float(error @ error)

    cases: dict[str, Callable[[], float]] = {
        CANDIDATE_LOOP: lambda: loops.candidate(CANDIDATE, *gains.values()),
        CANDIDATE_IN_TURN: lambda: loops.candidate(CANDIDATE, *gains.values(), turns=True),
    }
    for coupling, order in (("jacobi", ""), ("gauss_seidel", ", Gauss-Seidel")):
        for compiled in (False, True):
            how = {"coupling": coupling, "record": "mass.v", "compiled": compiled}
            simulation = _prepare(system, CANDIDATE, **how)
            case = "cosim" + order + ", compiled" * compiled
            cases[case] = lambda s=simulation: cost_of(s)
    for name, case in cases.items():
        loop = CANDIDATE_IN_TURN if "Gauss-Seidel" in name else CANDIDATE_LOOP
        np.testing.assert_allclose(case(), cases[loop](), rtol=1e-12)
    return interleaved(cases, 201, time.thread_time)


def _prepare(system, steps: int, **options):
    return system.prepare(step=ring.STEP, stop=steps * ring.STEP, constant_step=True, **options)
