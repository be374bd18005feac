"""The stage as an FMU: what its variables mean, and the training motion."""

from __future__ import annotations

import numpy as np
import pytest

STEP = 5e-4  # s


def test_training_motion_is_that_of_the_reference(alone, mass_run, training_force):
    """Against a Runge-Kutta method; tests/conformance holds a shorter motion against Radau."""
    with alone("stage", step=STEP, stop=10.0) as simulation:
        result = simulation.run(inputs={"u": np.append(training_force, 0.0)})
    reference = mass_run("rk4", STEP, training_force, pieces=200)
    assert abs(result["stage.v"][1:] - reference[:, 1]).max() < 1e-6  # m/s: 1e-3 mm/s
    assert abs(result["stage.x"][1:] - reference[:, 0]).max() < 1e-7


def test_equation_1_in_steady_sliding(alone):
    """m a + b v + F_f = u with a = 0, and F_f = g(v) -> F_c."""
    with alone("stage", step=1e-2, stop=30.0) as simulation:
        result = simulation.run(inputs={"u": 10.0}, parameters={"stage.b": 50.0})
    v, friction = result["stage.v"][-1], result["stage.F_f"][-1]
    assert friction == pytest.approx(5.999, rel=1e-9)
    assert v == pytest.approx((10.0 - 5.999) / 50.0, rel=1e-6)


def test_impulse_without_friction_gives_momentum(alone):
    smallest = {"stage.F_s": 1e-9, "stage.F_c": 1e-9, "stage.sigma_1": 0.0, "stage.b": 0.0}
    with alone("stage", step=STEP, stop=0.5) as simulation:
        result = simulation.run(inputs={"u": 5.557}, parameters=smallest)
    np.testing.assert_allclose(result["stage.v"], simulation.time, atol=1e-8)
    np.testing.assert_allclose(result["stage.x"], simulation.time**2 / 2, atol=1e-8)


def test_the_communication_step_hardly_matters(alone):
    """A force held over 2 ms, stepped in one piece or in ten."""
    ends = []
    for pieces in (1, 10):
        step = 2e-3 / pieces
        with alone("stage", step=step, stop=1.0) as simulation:
            held = np.repeat(20 * np.sin(15 * np.arange(500) * 2e-3), pieces)
            result = simulation.run(inputs={"u": np.append(held, 0.0)})
        ends.append(result["stage.v"][::pieces])
    assert abs(ends[0] - ends[1]).max() < 2e-7


def test_states_may_start_anywhere(alone):
    with alone("stage", step=STEP, stop=STEP) as simulation:
        result = simulation.run(parameters={"stage.x": 0.25, "stage.v": -0.01, "stage.z": -1e-5})
    assert (result["stage.x"][0], result["stage.v"][0]) == (0.25, -0.01)
    assert result["stage.x"][1] < 0.25
