"""The sampled PI controller, and the nominal loop that python-control designs."""

import control
import numpy as np
import pytest

from stickslip import models
from stickslip.servo.axis import Axis
from stickslip.servo.velocity_loop import LoopSpecification, design_velocity_loop
from tests.models.make_references import array, controlled

LOOP = design_velocity_loop(Axis(5.557, 6.6135, 1e-4), LoopSpecification(125, 50, 5e-4, 5e-4))
NAME = "velocity_controller"
T_S = 5e-4  # s
RECORD = tuple(f"{NAME}.{v}" for v in ("u", "v_est", "I", "J", "k"))
START = {v.name: v.start for v in models.load_model(NAME).variables if v.role == "parameter"}


def signals(t: np.ndarray) -> dict[str, np.ndarray]:
    """Return inputs over time, the encoder in steps of 0.4 um."""
    return {
        "v_cmd": 0.02 * np.sin(30 * t),
        "a_cmd": 0.6 * np.cos(30 * t),
        "x_enc": np.round(6e-4 * (1 - np.cos(30 * t)) / 4e-7) * 4e-7,
        "F_ff": 6.0 * np.sign(np.sin(30 * t)),
        "x_cmd": 6.2e-4 * (1 - np.cos(30 * t + 0.1)),
        "v_hat": 0.018 * np.sin(30 * t - 0.02),
    }


def test_nonlinear_damping_is_a_function_of_the_relative_error(alone):
    """The command steps to 1 mm while the encoder goes there, and then goes on."""
    with alone(NAME, RECORD, step=T_S, stop=0.2) as simulation:
        t = simulation.time
        inputs = {"x_enc": 2e-3 * t / 0.2, "x_cmd": 1e-3 * (t > 0), "v_hat": 0.01 + 0 * t}
        gains = {"K_p": 0.0, "K_i": 0.0, "use_v_hat": True, "alpha": 2.0, "gamma_v": 3000.0}
        u = simulation.run({f"{NAME}.{k}": v for k, v in gains.items()}, inputs)[f"{NAME}.u"]
    e = np.abs(1e-3 - inputs["x_enc"])[1:-1]
    rho = np.expm1(2.0 * (1.0 - np.minimum(e / e[0], 1.0))) / np.expm1(2.0)
    np.testing.assert_allclose(u[2:], -3000.0 * rho * 0.01, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("ratio", [0.1, 0.25, 0.3, 1 / 3, 0.7, 1.0, 3.0, 7.0])
def test_it_samples_at_its_own_period_whatever_the_step(alone, ratio):
    """Sample k takes the inputs of the step in which k T_s lies."""
    step = ratio * T_S
    with alone(NAME, RECORD, step=step, stop=200 * step) as simulation:
        inputs = signals(simulation.time)
        result = simulation.run(inputs=inputs)
    instants = np.arange(int(np.ceil(round(200 * step / T_S, 6)))) * T_S
    taken = np.searchsorted(simulation.time, instants + 1e-6 * T_S, side="right") - 1
    expected = controlled(START, {k: v[taken] for k, v in inputs.items()})
    samples = np.ceil(np.round(result.time / T_S, 6)).astype(int)
    np.testing.assert_array_equal(result[f"{NAME}.k"], samples)
    np.testing.assert_allclose(
        result[f"{NAME}.u"][1:], expected[samples[1:] - 1, 0], rtol=1e-11, atol=1e-11
    )


def test_a_run_may_start_at_any_time(alone):
    """Samples lie at multiples of T_s of the simulation's clock."""
    with alone(NAME, RECORD, step=T_S, start=1.0, stop=1.0 + 10 * T_S) as simulation:
        counts = simulation.run()[f"{NAME}.k"]
    np.testing.assert_array_equal(counts, 2000 + np.arange(11))


def test_gains_are_those_python_control_designs():
    for name in ("K_p", "K_i", "T_s", "tau_f"):
        assert START[name] == pytest.approx(getattr(LOOP, name), rel=1e-9)


NOMINAL = {v.name: v.start for v in models.load_model("nominal_loop").variables}


def test_start_values_are_the_loop_python_control_designs():
    """Compared where the choice of states does not show: in the pulse response."""
    A, B, C = array(NOMINAL, "A", 8, 8), array(NOMINAL, "B", 8), array(NOMINAL, "C", 8)
    x, response = B, [NOMINAL["D"]]
    for _ in range(200):
        response.append(C @ x)
        x = A @ x
    t = np.arange(201) * T_S
    designed = control.impulse_response(LOOP.nominal, t).outputs * T_S
    np.testing.assert_allclose(response, designed, rtol=1e-9, atol=1e-9 * abs(designed).max())
    assert NOMINAL["T_s"] == LOOP.T_s
