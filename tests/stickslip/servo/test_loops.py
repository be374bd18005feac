"""Velocity and position loops: gains, sensitivity, friction at steady speeds, saved states."""

import control
import numpy as np
import pytest

from stickslip import cosim
from stickslip.catalog.parameters import LUGRE, PAPER
from stickslip.servo.axis import LOOP, Axis, ControlError
from stickslip.servo.frequency import frequency_response
from stickslip.servo.measurement import level
from stickslip.servo.sensitivity import OpenLoop, peak_sensitivity
from stickslip.servo.systems import build_loop, paper_loop
from stickslip.servo.tuned_pi import tuned_pi
from stickslip.servo.velocity_loop import (
    LoopSpecification,
    close_velocity_loop,
    design_velocity_loop,
)
from tests.cosim.single import exposed

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


AXES = {
    "the paper's": (Axis(5.557, 6.6, 1e-4), LOOP),
    "light, slow loop": (Axis(0.8, 0.1, 3e-4), LoopSpecification(40.0, 65.0, T_s=1e-3)),
    "heavy": (Axis(40.0, 60.0, 1e-3), LoopSpecification(30.0, 55.0, T_s=5e-4, tau_f=1e-3)),
}


def sensitivity(loop):
    """Return max |1 / (1 + L)| by python-control, on a grid of our own."""
    w = np.linspace(1e-3, 1.0, 4000) * np.pi / loop.T_s
    return np.abs(control.feedback(1, loop.open_loop)(np.exp(1j * w * loop.T_s))).max()


@pytest.mark.slow
@pytest.mark.parametrize(("axis", "specification"), AXES.values(), ids=AXES)
def test_it_rejects_friction_best_at_the_same_peak_sensitivity(axis, specification):
    loop = design_velocity_loop(axis, specification)
    tuned = tuned_pi(loop)
    limit = sensitivity(loop)
    assert peak_sensitivity(loop) == pytest.approx(limit, rel=1e-3)
    assert sensitivity(tuned) == pytest.approx(limit, rel=1e-3)
    assert tuned.K_i > 1.2 * loop.K_i
    gains = (axis, loop.T_s, loop.tau_f)
    for factor in np.linspace(0.5, 1.5, 11):  # no other K_p allows 1 % more K_i
        other = close_velocity_loop(*gains, factor * tuned.K_p, 1.01 * tuned.K_i)
        assert sensitivity(other) > limit


def test_no_state_and_no_step_are_refused(fmus, loop, tmp_path):
    system = paper_loop(fmus, loop, {})
    with system.prepare(step=loop.T_s, stop=0.1) as simulation:
        with pytest.raises(cosim.SimulationError, match="no state to save"):
            simulation.save(tmp_path / "a.state")
        simulation.run(until=0.05)
        path = simulation.save(tmp_path / "a.state")
    with (
        system.prepare(step=loop.T_s, stop=0.05) as shorter,
        pytest.raises(cosim.ExperimentError, match="no step left"),
    ):
        shorter.resume(path)


SPEEDS = np.array([1e-4, 4e-4, 1e-3, 3e-3])


@pytest.mark.parametrize("delta", [1.0, 2.0])
@pytest.mark.parametrize("v", SPEEDS)
def test_it_is_where_the_compensator_settles(fmus, v, delta):
    p = {name: PAPER[name] for name in LUGRE} | {"delta": delta}
    system = exposed(fmus / "compensator.fmu", {**p, "hold": False}, "compensator")
    stop = 20.0 * PAPER["F_s"] / PAPER["sigma_0"] / v  # a bristle's way, many times
    with system.prepare(step=stop / 100.0, stop=stop, record=["compensator.F_f"]) as simulation:
        settled = simulation.run(inputs={"v": np.full(101, v)})["compensator.F_f"][-1]
    assert settled == pytest.approx(float(level(p, v)), rel=1e-6)
