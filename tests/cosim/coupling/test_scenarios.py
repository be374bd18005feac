"""Scenarios mean the same whatever the coupling."""

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim import Adaptive, Coupling, Scenario
from tests.cosim.single import halves

STEP, N = 0.01, 60
COUPLINGS = [
    "gauss_seidel",
    Coupling("jacobi", degree=1),
    Coupling("gauss_seidel", degree=2),
    Coupling("iterative", degree=0),
    Coupling("iterative", degree=1, adaptive=Adaptive(1e-5)),
    Coupling("jacobi", every={"right": 4}),
    Coupling("gauss_seidel", every={"left": 3}),
]
each_coupling = pytest.mark.parametrize("coupling", COUPLINGS, ids=str)


@pytest.fixture(params=[2, 3])
def system(two_masses, linear, request):
    return two_masses.system(linear, request.param)


def run(system, scenario, coupling):
    with system.prepare(step=STEP, stop=N * STEP, coupling=coupling) as simulation:
        before = simulation.run().values
        result = simulation.run(scenario=scenario)
        np.testing.assert_array_equal(simulation.run().values, before)  # nothing stays behind
    return result


def until_30(system, folder, coupling, **scenarios):
    """Return a whole run, and the rest of one that was saved at step 30."""
    spec = {"step": STEP, "stop": N * STEP, "coupling": coupling, "until": 30 * STEP}
    return halves(system, folder / "a.state", **spec, **scenarios)


@each_coupling
def test_a_replaced_signal_cuts_the_loop(system, linear, coupling):
    """From its first value on, the left mass is driven by a given force alone."""
    force = np.sin(3 * STEP * np.arange(N + 1))
    result = run(system, Scenario().override("right.y1", force), coupling)
    np.testing.assert_array_equal(result["right.y1"], force)
    if isinstance(coupling, Coupling) and coupling.adaptive:
        return  # its steps between points depend on signals that are no longer there
    alone = cosim.System("alone")
    alone.add("left", system.components["left"])
    for name, value in system.parameters.items():
        if name.startswith("left."):
            alone.set(name, value)
    alone.add("right", linear(2, "d11"), {"d11": 1.0})  # what is replaced, with the same coupling
    alone.expose("f", "right.u1")
    alone.connect("right.y1", "left.u1")
    again = run(alone, Scenario().override("right.y1", force), coupling)
    np.testing.assert_allclose(again["left.y1"], result["left.y1"], rtol=1e-12)


@each_coupling
def test_a_scenario_that_changes_nothing_changes_no_bit(system, coupling):
    quiet = Scenario().add_noise("left.y1", 0.0, 1)
    plain = run(system, None, coupling)
    np.testing.assert_array_equal(run(system, quiet, coupling).values, plain.values)


@each_coupling
def test_a_scenario_may_begin_in_a_resumed_run(system, tmp_path, coupling):
    scenario = Scenario().set("left.y1", 2.0, at=33 * STEP).stick("right.y1", 35 * STEP)
    whole, rest = until_30(system, tmp_path, coupling, first=Scenario(), scenario=scenario)
    np.testing.assert_array_equal(rest.values, whole.values[30:])


def test_adaptive_steps_do_not_shrink_at_a_jump_of_a_scenario(system):
    coupling = Coupling("gauss_seidel", degree=2, adaptive=Adaptive(1e-4))
    scenario = Scenario().set("left.y1", 5.0, at=20 * STEP).set("right.y1", 0.0, at=20 * STEP)
    with system.prepare(step=STEP, stop=N * STEP, coupling=coupling) as simulation:
        simulation.run(scenario=scenario, until=20 * STEP)
        before = simulation.effort["rejected"]
        simulation.run(scenario=scenario)
        assert simulation.effort["rejected"] <= before + 8


@each_coupling
def test_a_stuck_signal_may_be_noisy_and_is_resumed(system, tmp_path, coupling):
    noise = 0.1 * np.random.default_rng(2).standard_normal(N + 1)
    scenario = Scenario().stick("left.y1", 20 * STEP, 40 * STEP).add_noise("left.y1", 0.1, 2, 0.25)
    free = run(system, None, coupling)["left.y1"]
    whole, rest = until_30(system, tmp_path, coupling, scenario=scenario)
    np.testing.assert_array_equal(whole["left.y1"][20:25], free[19])
    np.testing.assert_array_equal(whole["left.y1"][25:40], free[19] + noise[25:40])
    np.testing.assert_array_equal(rest.values, whole.values[30:])
