"""Coupled runs that go on elsewhere, lie in a container, or meet numbers near zero."""

import math

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim import Adaptive, Coupling

STEP, HALF, STOP = 0.01, 0.3, 0.8
COUPLINGS = [
    Coupling("jacobi", degree=1),
    Coupling("gauss_seidel", degree=2),
    Coupling("iterative"),
    Coupling("iterative", degree=2),
    Coupling("gauss_seidel", degree=2, adaptive=Adaptive(1e-6)),
    Coupling("iterative", degree=2, adaptive=Adaptive(1e-6)),
    Coupling("jacobi", every={"left": 3}),
    Coupling("gauss_seidel", every={"right": 4}),
]


@pytest.mark.parametrize("coupling", COUPLINGS, ids=str)
@pytest.mark.parametrize("record", [None, ["left.y1"]], ids=["all", "one"])
def test_bit_for_bit_with_every_coupling(two_masses, linear, tmp_path, version, coupling, record):
    system = two_masses.system(linear, version)
    if not coupling.every:
        system.add("loop", linear(version, "d11"), {"d11": 0.5, "cubic": -0.01, "f1": 1.0})
        # A nonlinear loop of its own, whose gain is below 1 for Jacobi, and a signal from outside.
        system.connect("loop.y1", "loop.u1")
        system.expose("x", "loop.u2")
    inputs = {"x": np.sin} if system.inputs else {}
    stop = 0.84 if coupling.every else STOP
    spec = {"step": STEP, "stop": stop, "coupling": coupling, "record": record}
    with system.prepare(**spec) as simulation:
        whole = simulation.run(inputs=inputs)
        effort = dict(simulation.effort)
        first = simulation.run(inputs=inputs, until=HALF)
        path = simulation.save(tmp_path / "half.state")
    with system.prepare(**spec) as another:
        rest = another.resume(path, inputs)
        assert another.effort == effort
    n = len(first.time)
    np.testing.assert_array_equal(first.values, whole.values[:n])
    np.testing.assert_array_equal(rest.values, whole.values[n - 1 :])
    assert rest.values.std() > 0


def test_rounding_left_by_derivatives_does_not_reach_the_solver(linear, version):
    """Bit for bit as with the same FMU that leaves nothing; an oscillation, so all of it counts."""
    results = []
    for flags in ((), ("-DLEAVES_ROUNDING",)):
        system = cosim.System("oscillator")
        parameters = {"a12": 1.0, "a21": -1.0, "c11": 1.0, "x1": 1.0}
        system.add("a", linear(version, exchange=True, flags=flags), parameters)
        with system.prepare(step=0.01, stop=5.0) as simulation:
            results.append(simulation.run()["a.y1"])
    assert np.array_equal(*results)
    assert results[0][-1] == pytest.approx(math.cos(5.0), abs=1e-3)
    assert 1.0 + 1e-30 == 1.0
