"""The nominal loop: the sampled linear system that python-control designs."""

from __future__ import annotations

import control
import numpy as np

from stickslip import models
from stickslip.servo.axis import Axis
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop

NAME = "nominal_loop"
T_S = 5e-4  # s
START = {v.name: v.start for v in models.load_model(NAME).variables if v.role == "parameter"}


def test_start_values_are_the_loop_python_control_designs():
    """Compared where the choice of states does not show: in the pulse response."""
    loop = design_velocity_loop(Axis(5.557, 6.6135, 1e-4), LoopSpecification(125, 50, 5e-4, 5e-4))
    A = np.array([[START[f"A[{i},{k}]"] for k in range(1, 9)] for i in range(1, 9)])
    B, C = (np.array([START[f"{name}[{i}]"] for i in range(1, 9)]) for name in "BC")
    x, response = B, [START["D"]]
    for _ in range(200):
        response.append(C @ x)
        x = A @ x
    t = np.arange(201) * T_S
    designed = control.impulse_response(loop.nominal, t).outputs * T_S
    np.testing.assert_allclose(response, designed, rtol=1e-9, atol=1e-9 * abs(designed).max())
    assert START["T_s"] == loop.T_s
