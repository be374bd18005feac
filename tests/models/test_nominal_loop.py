"""The nominal loop: the sampled linear system that python-control designs."""

from __future__ import annotations

import control
import numpy as np
import pytest

from stickslip import models
from stickslip.servo.axis import Axis
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop

NAME = "nominal_loop"
T_S = 5e-4  # s
START = {v.name: v.start for v in models.load_model(NAME).variables if v.role == "parameter"}


@pytest.fixture(scope="module")
def loop():
    return design_velocity_loop(Axis(5.557, 6.6135, 1e-4), LoopSpecification(125, 50, 5e-4, 5e-4))


def matrices() -> tuple[np.ndarray, ...]:
    A = np.array([[START[f"A[{i},{k}]"] for k in range(1, 9)] for i in range(1, 9)])
    B, C = (np.array([START[f"{name}[{i}]"] for i in range(1, 9)]) for name in "BC")
    return A, B, C


def test_start_values_are_the_loop_python_control_designs(loop):
    """Compared where the choice of states does not show: in the pulse response."""
    A, B, C = matrices()
    x, response = B, [START["D"]]
    for _ in range(200):
        response.append(C @ x)
        x = A @ x
    t = np.arange(201) * T_S
    designed = control.impulse_response(loop.nominal, t).outputs * T_S
    np.testing.assert_allclose(response, designed, rtol=1e-9, atol=1e-9 * abs(designed).max())
    assert START["T_s"] == loop.T_s


def test_difference_equations(alone):
    """v_r = C x+ + D v_cmd: the velocity at the end of the period that v_cmd begins."""
    A, B, C = matrices()
    with alone(NAME, step=T_S, stop=0.5) as simulation:
        v_cmd = 0.03 * np.sin(50 * simulation.time) + 0.01 * (simulation.time > 0.2)
        result = simulation.run(inputs={"v_cmd": v_cmd})
    x, expected = np.zeros(8), [0.0]
    for v in v_cmd[:-1]:
        x = A @ x + B * v
        expected.append(C @ x + START["D"] * v)
    np.testing.assert_allclose(result[f"{NAME}.v_r"], expected, rtol=0, atol=1e-14)


def test_direct_gain_passes_the_command_on(alone):
    with alone(NAME, step=T_S, stop=10 * T_S) as simulation:
        parameters = {f"{NAME}.D": 2.0} | {f"{NAME}.C[{i}]": 0.0 for i in range(1, 9)}
        v_cmd = np.arange(11) * 0.1
        result = simulation.run(parameters, {"v_cmd": v_cmd})
    np.testing.assert_array_equal(result[f"{NAME}.v_r"], np.append(0.0, 2.0 * v_cmd[:-1]))
