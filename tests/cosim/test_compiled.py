"""Steps compiled for one system do what the tables do."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.kernel import MOST_COMPONENTS


def circle(make, n):
    """Gains and integrators of both versions in a circle, and one that nothing feeds."""
    system = cosim.System("circle")
    for i in range(n):
        kind = "gain" if i % 3 else "integrator"
        system.add(f"c{i}", make(kind, 2 + i % 2), {"k": 0.5})
    for i in range(n - 1):
        system.connect(f"c{i}.y", f"c{(i + 1) % (n - 1)}.u")
    return system


@pytest.mark.parametrize("record", [None, ["c1.y", "c0.*"]], ids=["all", "some"])
@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
@pytest.mark.parametrize("n", [4, MOST_COMPONENTS, MOST_COMPONENTS + 1])
def test_compiled_steps_give_the_same_bits(make, n, coupling, record):
    spec = {"step": 1e-3, "stop": 1.0, "coupling": coupling, "record": record}
    system = circle(make, n)
    table = system.prepare(**spec).run()
    compiled = system.prepare(**spec, compiled=True).run()
    assert compiled.names == table.names
    np.testing.assert_array_equal(compiled.values, table.values)


def test_a_system_without_components_can_be_compiled():
    result = cosim.System().prepare(step=0.5, stop=1.0, compiled=True).run()
    assert len(result.time) == 3
    assert not result.names
