"""What is designed here is what the FMUs do."""

from __future__ import annotations

import numpy as np
from closed_loop import follow, ideal_servo, nominal_values

from stickslip import cosim

STOP = 0.1


def test_nominal_loop_fmu_gives_the_step_response(fmus, loop):
    system = cosim.System()
    system.add("nominal", fmus / "nominal_loop.fmu", nominal_values(loop))
    system.expose("v_cmd", "nominal.v_cmd")
    with system.prepare(step=loop.T_s, stop=STOP) as simulation:
        result = simulation.run(inputs={"v_cmd": 1.0})
    t, v = loop.step_response(STOP)
    np.testing.assert_allclose(result.time, t, rtol=0, atol=1e-15)
    np.testing.assert_allclose(result["nominal.v_r"], v, rtol=0, atol=1e-9)


def test_controller_and_drive_follow_the_nominal_loop(fmus, loop):
    # The drive brings its motor's lag in as mean forces over sub-steps, which are no longer than
    # the communication step; the controller samples every T_s all the same.
    substeps, tolerance = (20, 1e-4) if loop.axis.tau_i > 0.0 else (1, 1e-8)
    height = 0.02  # m/s, which takes less than half of the force limit
    with ideal_servo(fmus, loop).prepare(step=loop.T_s / substeps, stop=STOP) as simulation:
        result = simulation.run(inputs={"v_cmd": height})
    _, v = loop.step_response(STOP)
    assert np.abs(result["controller.u"]).max() < 205.0
    difference = result["drive.v"][::substeps] / height - v
    assert np.abs(difference).max() < tolerance


def test_a_feedforward_force_does_what_the_compliance_says(fmus, loop):
    substeps = 20
    with ideal_servo(fmus, loop).prepare(step=loop.T_s / substeps, stop=STOP) as simulation:
        result = simulation.run(inputs={"F_ff": 10.0})
    n = round(STOP / loop.T_s) + 1
    expected = follow(loop, np.zeros(n), np.full(n, 10.0))
    assert np.abs(expected).max() > 1e-3
    np.testing.assert_allclose(result["drive.v"][::substeps], expected, rtol=0, atol=1e-6)
