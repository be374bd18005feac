"""A chain in one FMU: no units, and a state to go back to."""

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from stickslip import cosim

STEP, STOP = 1e-3, 0.5


@pytest.mark.slow
def test_iterates_as_a_component_among_others(linear, tmp_path):
    """What goes back and repeats its steps, as the iteration asks of it, gives what it holds."""
    chain = cosim.System("chain")
    chain.add("first", linear(2), {"a11": -2.0, "b11": 1.0, "c11": 1.0})
    chain.add("second", linear(3), {"a11": -3.0, "b11": 1.0, "c11": 1.0})
    chain.connect("first.y1", "second.u1")
    chain.expose("u", "first.u1")
    chain.expose_output("y", "second.y1")
    path = cosim.write_fmu(chain, tmp_path / "chain.fmu", step=STEP, fmi=3)
    assert not validate_fmu(str(path))

    def closed(inner):
        system = cosim.System("closed")
        system.add("back", linear(2), {"a11": -1.0, "b11": -5.0, "c11": 1.0, "x1": 1.0})
        source, target = inner(system)
        system.connect("back.y1", target)
        system.connect(source, "back.u1")
        coupling = cosim.Coupling("iterative", degree=0)
        with system.prepare(step=STEP, stop=STOP, coupling=coupling) as simulation:
            return simulation.run()["back.y1"], simulation.effort

    def packed(system):
        system.add("chain", path)
        return "chain.y", "chain.u"

    trajectory, effort = closed(packed)
    assert effort["sweeps"] > effort["steps"]
    t = np.arange(len(trajectory)) * STEP
    states = np.array([[-1.0, 0.0, -5.0], [1.0, -2.0, 0.0], [0.0, 1.0, -3.0]])
    values, vectors = np.linalg.eig(states)
    weights = np.linalg.solve(vectors, [1.0, 0.0, 0.0])
    exact = (vectors[0] * weights * np.exp(values * t[:, None])).sum(axis=1).real
    np.testing.assert_allclose(trajectory, exact, atol=5 * STEP)
