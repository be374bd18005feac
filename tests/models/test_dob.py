"""The disturbance observer alone: poles, and what it is a part of."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from stickslip import cosim, models
from stickslip.servo.axis import Axis
from stickslip.servo.velocity_filter import FilterSpecification, Observer, design_velocity_filter

T = 5e-4  # s
P = {v.name: v.start for v in models.load_model("dob").variables if v.role == "parameter"}


def observe(fmus, x_enc, F_m, F_in=None, name="dob", **parameters):
    system = cosim.System()
    system.add("fmu", fmus / f"{name}.fmu", parameters)
    signals = {"x_enc": x_enc, "F_m": F_m, "F_in" if name == "dob" else "F_ff": F_in}
    signals = {k: np.zeros(len(x_enc)) if v is None else v for k, v in signals.items()}
    for signal in signals:
        system.expose(signal, f"fmu.{signal}")
    with system.prepare(step=T, stop=T * (len(x_enc) - 1)) as simulation:
        return simulation.run(inputs=signals)


def axis(force: float, n: int, change: float = 0.0) -> np.ndarray:
    """Return the position at n + 1 samples under a force alone, which changes at each sample."""
    rates = np.array([[0.0, 1.0, 0.0], [0.0, -P["b"] / P["m"], 1.0 / P["m"]], [0.0, 0.0, 0.0]])
    state, move, x = np.array([0.0, 0.0, force]), expm(rates * T), []
    for _ in range(n + 1):
        x.append(state[0])
        state = move @ state + [0.0, 0.0, change]
    return np.array(x)


def test_it_finds_a_constant_force_with_the_poles_of_its_gains(fmus):
    """The error decays as (A - L C A)^k of the sampled axis with x, v and d."""
    d = observe(fmus, axis(3.0, 400), np.zeros(401))["fmu.d_hat"]
    rates = np.array([[0.0, 1.0, 0.0], [0.0, -P["b"] / P["m"], 1.0 / P["m"]], [0.0, 0.0, 0.0]])
    A, L = expm(rates * T), np.array([[P["L_x"]], [P["L_v"]], [P["L_d"]]])
    closed = A - L @ A[:1]
    assert np.abs(np.linalg.eigvals(closed)).max() < 1.0
    error = np.array([0.0, 0.0, 3.0])
    for k in range(200):
        assert 3.0 - d[k + 1] == pytest.approx(error[2], abs=1e-8)
        error = closed @ error
    assert d[-1] == pytest.approx(3.0, abs=1e-6)


def test_its_estimate_is_that_of_the_velocity_filter(fmus):
    t = np.arange(301) * T
    x, F, known = 1e-3 * np.sin(20 * t), 5.0 * np.cos(30 * t), 2.0 * np.sign(np.cos(20 * t))
    dob = observe(fmus, x, F, known)
    plain = observe(fmus, x, F, known, name="velocity_filter")
    assert dob["fmu.d_hat"].tobytes() == plain["fmu.d_hat"].tobytes()
    passed = np.append(0.0, known[:-1])
    np.testing.assert_array_equal(dob["fmu.F"], passed - dob["fmu.d_hat"])


def test_only_order_2_follows_a_ramp_without_an_error(fmus):
    """Of order 1 the error is what one sample adds over what the correction takes away."""
    x, rate = axis(0.0, 800, 40.0 * T), 40.0
    weights = FilterSpecification(4e-7, 0.05, 1.5), FilterSpecification(4e-7, 0.05, 300.0, 2)
    designed = [design_velocity_filter(Axis(P["m"], P["b"], P["tau_i"]), T, w) for w in weights]
    lag, none = (
        rate * T * np.arange(-1, 800)
        - observe(fmus, x, 0 * x, **Observer(one).parameters())["fmu.d_hat"]
        for one in designed
    )
    first = designed[0]
    A = first.disturbance().A[:3, :3]
    expected = np.linalg.solve(np.eye(3) - A, [0.0, 0.0, rate * T])[2]
    assert lag[-1] == pytest.approx(expected, rel=1e-6)
    assert abs(none[-1]) < 1e-6 * expected
