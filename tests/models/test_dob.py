"""The disturbance observer alone: what it is a part of, and its orders."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from stickslip import models
from stickslip.servo.axis import Axis
from stickslip.servo.velocity_filter import FilterSpecification, Observer, design_velocity_filter

T = 5e-4  # s
P = {v.name: v.start for v in models.load_model("dob").variables if v.role == "parameter"}


def axis(force: float, n: int, change: float = 0.0) -> np.ndarray:
    """Return the position at n + 1 samples under a force alone, which changes at each sample."""
    rates = np.array([[0.0, 1.0, 0.0], [0.0, -P["b"] / P["m"], 1.0 / P["m"]], [0.0, 0.0, 0.0]])
    state, move, x = np.array([0.0, 0.0, force]), expm(rates * T), []
    for _ in range(n + 1):
        x.append(state[0])
        state = move @ state + [0.0, 0.0, change]
    return np.array(x)


def test_its_estimate_is_that_of_the_velocity_filter(observe):
    t = np.arange(301) * T
    x, F, known = 1e-3 * np.sin(20 * t), 5.0 * np.cos(30 * t), 2.0 * np.sign(np.cos(20 * t))
    signals = {"x_enc": x, "F_m": F}
    dob = observe("dob", {**signals, "F_in": known})
    plain = observe("velocity_filter", {**signals, "F_ff": known})
    assert dob["fmu.d_hat"].tobytes() == plain["fmu.d_hat"].tobytes()
    passed = np.append(0.0, known[:-1])
    np.testing.assert_array_equal(dob["fmu.F"], passed - dob["fmu.d_hat"])


def test_only_order_2_follows_a_ramp_without_an_error(observe):
    """Of order 1 the error is what one sample adds over what the correction takes away."""
    x, rate = axis(0.0, 800, 40.0 * T), 40.0
    weights = FilterSpecification(4e-7, 0.05, 1.5), FilterSpecification(4e-7, 0.05, 300.0, 2)
    designed = [design_velocity_filter(Axis(P["m"], P["b"], P["tau_i"]), T, w) for w in weights]
    lag, none = (
        rate * T * np.arange(-1, 800)
        - observe("dob", {"x_enc": x, "F_m": 0 * x}, **Observer(one).parameters())["fmu.d_hat"]
        for one in designed
    )
    first = designed[0]
    A = first.disturbance().A[:3, :3]
    expected = np.linalg.solve(np.eye(3) - A, [0.0, 0.0, rate * T])[2]
    assert lag[-1] == pytest.approx(expected, rel=1e-6)
    assert abs(none[-1]) < 1e-6 * expected
