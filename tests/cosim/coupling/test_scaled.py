"""A scaled connection means the same however components step."""

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.system.scaling import Link, Scaling

LINK = Link(Scaling(factor=-1.5, offset=0.25))


@pytest.mark.parametrize("method", ["gauss_seidel", "iterative"])
def test_in_a_loop_that_is_solved(linear, method):
    system = cosim.System("gains")
    system.add("a", linear(2, "d11", "d12"), {"d11": 2.0, "d12": 1.0, "f1": 0.7})
    system.add("b", linear(2, "d11"), {"d11": 3.0})
    system.connect("a.y1", "b.u1")
    system.connect("b.y1", "a.u1", LINK)
    a = system.prepare(step=1e-2, stop=0.5, coupling=method).run()["a.y1"]
    # a = 2 (-1.5 3 a + 0.25) + 0.7
    np.testing.assert_allclose(a, (2.0 * 0.25 + 0.7) / (1.0 + 2.0 * 1.5 * 3.0), atol=1e-11)


@pytest.mark.parametrize("compiled", [False, True])
def test_in_a_chain(linear, compiled):
    system = cosim.System("chain")
    system.add("a", linear(2, "d11"), {"d11": 2.0})
    system.add("b", linear(3, "d11"), {"d11": 1.0})
    system.expose("w", "a.u1")
    system.connect("a.y1", "b.u1", LINK)
    with system.prepare(step=1e-2, stop=0.5, compiled=compiled) as simulation:
        result = simulation.run(inputs={"w": np.sin(9.0 * simulation.time)})
    np.testing.assert_array_equal(result["b.y1"][1:], -1.5 * result["a.y1"][1:] + 0.25)
