"""A run that was saved and goes on elsewhere equals the one that was never interrupted."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip.cosim import Adaptive, Coupling
from stickslip.cosim.assembly.coupled import Coupled

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


@pytest.mark.parametrize("version", [2, 3])
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


def test_what_is_remembered_matters(two_masses, linear, tmp_path, monkeypatch):
    """Without the points before, the same run goes another way."""
    spec = {"step": STEP, "stop": STOP, "coupling": Coupling("jacobi", degree=2)}
    system = two_masses.system(linear)
    with system.prepare(**spec) as simulation:
        whole = simulation.run()
        simulation.run(until=HALF)
        path = simulation.save(tmp_path / "half.state")
    monkeypatch.setattr(Coupled, "recall", lambda *_: None)
    with system.prepare(**spec) as another:
        rest = another.resume(path)
    assert not np.array_equal(rest.values[-1], whole.values[-1])
