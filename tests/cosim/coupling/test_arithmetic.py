"""The solver of Model Exchange computes as usual, whatever the FMU leaves behind."""

import math

import numpy as np
import pytest

from stickslip import cosim


@pytest.mark.parametrize("version", [2, 3])
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
