"""Friction at steady speeds, against the compensator FMU and differences."""

import numpy as np
import pytest

from stickslip import cosim
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.servo.measurement import level, slope

SPEEDS = np.array([1e-4, 4e-4, 1e-3, 3e-3])


@pytest.mark.parametrize("delta", [1.0, 2.0])
@pytest.mark.parametrize("v", SPEEDS)
def test_it_is_where_the_compensator_settles(fmus, v, delta):
    p = {name: PAPER[name] for name in LUGRE} | {"delta": delta}
    system = cosim.System("steady")
    system.add("compensator", fmus / "compensator.fmu", {**p, "hold": False})
    system.expose("v", "compensator.v")
    stop = 20.0 * PAPER["F_s"] / PAPER["sigma_0"] / v  # a bristle's way, many times
    with system.prepare(step=stop / 100.0, stop=stop, record=["compensator.F_f"]) as simulation:
        settled = simulation.run(inputs={"v": np.full(101, v)})["compensator.F_f"][-1]
    assert settled == pytest.approx(float(level(p, v)), rel=1e-6)


@pytest.mark.parametrize("delta", [1.0, 2.0])
def test_its_slope_is_its_derivative(delta):
    p = {**PAPER, "delta": delta}
    tiny = 1e-4 * SPEEDS
    differences = (level(p, SPEEDS + tiny) - level(p, SPEEDS - tiny)) / (2.0 * tiny)
    np.testing.assert_allclose(slope(p, SPEEDS), differences, rtol=1e-5, atol=1e-6)
