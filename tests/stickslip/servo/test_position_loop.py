"""The position loop around a velocity loop: its nominal response and its sensitivity."""

import numpy as np
import pytest

from stickslip.servo.axis import ControlError
from stickslip.servo.frequency import frequency_response
from stickslip.servo.sensitivity import OpenLoop, peak_sensitivity
from stickslip.servo.systems import build_loop
from stickslip.servo.velocity_loop import close_velocity_loop

K_X = 75.4


def closed(loop, K_i=None, K_x=K_X, **changes):
    gains = loop.T_s, loop.tau_f, loop.K_p, loop.K_i if K_i is None else K_i
    return close_velocity_loop(loop.axis, *gains, K_x=K_x, **changes)


@pytest.mark.parametrize("share", [1.0, 0.4])
def test_without_friction_the_fmus_move_as_the_nominal_loop(fmus, loop, share):
    ideal = {"F_s": 1e-9, "F_c": 1e-9, "sigma_0": 1e-3, "sigma_1": 0.0, "encoder": 0, "dac": 0}
    cascade = closed(loop, velocity_feedforward=share)
    t = np.arange(801) * loop.T_s
    v_cmd = 0.01 * np.sin(2.0 * np.pi * 5.0 * t)
    record = ("drive.v", "drive.x", "nominal.v_r")
    system = build_loop(fmus, cascade, [])
    with system.prepare(step=loop.T_s, stop=float(t[-1]), record=record) as simulation:
        run = simulation.run({f"drive.{n}": x for n, x in ideal.items()}, cascade.commands(v_cmd))
    assert run["drive.v"] == pytest.approx(run["nominal.v_r"], abs=1e-9)
    v, x = cascade.response(v_cmd)
    assert run["drive.v"] == pytest.approx(v, abs=1e-9)
    assert run["drive.x"] == pytest.approx(x, abs=1e-8)


@pytest.mark.parametrize("share", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("integral", [True, False])
def test_the_lag_at_constant_speed(loop, share, integral):
    """The position error commands what the feedforward lacks, and without an integral b v / K_p."""
    cascade = closed(loop, velocity_feedforward=share, K_i=loop.K_i if integral else 0.0)
    v_cmd = np.full(4000, 0.03)
    _, x = cascade.response(v_cmd)
    lag = cascade.commands(v_cmd)["x_cmd"][-1] - x[-1]
    viscous = 0.0 if integral else loop.axis.b * 0.03 / loop.K_p
    # The velocity estimate is exact at constant speed; the first sample ends at T_s.
    assert lag == pytest.approx(((1.0 - share) * 0.03 + viscous) / K_X, abs=2e-8)


def test_the_sensitivity_is_that_of_the_open_loop(loop):
    """The outer loop multiplies the open loop by 1 + K_x / (velocity estimate per position)."""
    cascade = loop.changed(K_x=K_X)
    opened = OpenLoop(cascade)
    z = np.exp(2j * np.pi * opened.f * loop.T_s)
    keep = np.exp(-loop.T_s / loop.tau_f)
    estimate = (1.0 - 1.0 / z) / loop.T_s * (1.0 - keep) / (1.0 - keep / z)  # per position
    plain = frequency_response(loop.open_loop, opened.f)
    expected = 1.0 / (1.0 + plain * (1.0 + K_X / estimate))
    assert opened.response().at_command == pytest.approx(expected, rel=1e-6)
    assert peak_sensitivity(cascade) > peak_sensitivity(loop)


def test_an_outer_loop_that_is_too_fast_is_refused(loop):
    with pytest.raises(ControlError, match="leave the velocity loop unstable"):
        loop.changed(K_x=5000.0)
