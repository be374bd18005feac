"""The ring of three FMUs that peers are measured with, against the plain C loop."""

import numpy as np
import pytest

from benchmarks.coupling import ring
from benchmarks.coupling.ring import Loops
from stickslip import cosim

N = 20_000


@pytest.fixture(scope="module", params=[2, 3], ids=["FMI 2.0", "FMI 3.0"])
def version(request):
    return request.param


@pytest.fixture(scope="module")
def system(version, tmp_path_factory):
    return ring.system(tmp_path_factory.mktemp("ring"), version)


@pytest.fixture(scope="module")
def loops(version):
    return Loops(version)


def prepare(system, n=N, coupling="jacobi", **options):
    times = {"step": ring.STEP, "stop": n * ring.STEP}
    return system.prepare(**times, coupling=coupling, constant_step=True, **options)


@pytest.mark.parametrize("compiled", [False, True], ids=["tables", "compiled"])
@pytest.mark.parametrize("coupling", ["jacobi", "gauss_seidel"])
def test_every_signal_is_that_of_the_plain_c_loop_to_the_bit(system, loops, coupling, compiled):
    expected = (loops.plain if coupling == "jacobi" else loops.in_turn)(N)
    with prepare(system, N, coupling, compiled=compiled) as simulation:
        for _ in range(2):
            result = simulation.run()
            np.testing.assert_array_equal(result.values[1:], expected)
    assert abs(result["mass.v"][-1] - 0.2) < 0.01
    with prepare(system, N, coupling, compiled=compiled, record=["mass.x"]) as simulation:
        np.testing.assert_array_equal(simulation.run()["mass.x"][1:], expected[:, 2])


@pytest.mark.parametrize("coupling", ["jacobi", "gauss_seidel"])
def test_a_candidate_costs_what_the_c_loop_says_to_the_bit(system, version, loops, coupling):
    compiled = version == 2 and coupling == "gauss_seidel"
    cost = cosim.Deviation("mass.v", 0.2, begin=ring.STEP)
    record = cosim.Record(sum_of_squares={"cost": cost})
    with prepare(system, 10_000, coupling, record=record, compiled=compiled) as simulation:
        result = simulation.run({"controller.K_p": 41.0, "controller.K_i": 910.0})
    turns = coupling == "gauss_seidel"
    assert result.sum_of_squares["cost"] == loops.candidate(10_000, 41.0, 910.0, turns=turns)


def test_rings_of_more_fmus_than_a_group_step_all_of_them(tmp_path):
    """All parts of a longer ring move alike, since each sees what the first ring sees."""
    with prepare(ring.system(tmp_path, 2, 30), 1_000) as simulation:
        result = simulation.run()
    with prepare(ring.system(tmp_path, 2), 1_000) as simulation:
        first = simulation.run()
    for i in range(1, 10):
        np.testing.assert_array_equal(result[f"mass{i}.v"], first["mass.v"])
