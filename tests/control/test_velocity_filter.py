"""The designed filter: its gains against the Kalman recursion, and its loop against the FMUs'."""

import dataclasses

import numpy as np
import pytest
from scipy.linalg import expm

from stickslip.servo.axis import Axis, ControlError
from stickslip.servo.systems import build_loop
from stickslip.servo.velocity_filter import FilterSpecification, design_velocity_filter
from stickslip.servo.velocity_loop import LoopSpecification, VelocityLoop, design_velocity_loop
from tests.control.closed_loop import NO_FRICTION, ideal_servo

T_S = 5e-4
SPECIFICATION = FilterSpecification(encoder_step=4e-7, force_noise=0.05, disturbance_rate=1.5)


def kalman_gain(A, Q, P, n):
    """Return the gain after n predictions and corrections."""
    for _ in range(n):
        ahead = A @ P @ A.T + Q
        gain = ahead[:, 0] / (ahead[0, 0] + SPECIFICATION.encoder_step**2 / 12)
        P = ahead - np.outer(gain, ahead[0])
    return gain


@pytest.mark.parametrize("rate", [0.5, 5.0, 500.0])
@pytest.mark.parametrize("tau_i", [0.0, 1e-4])
def test_gains_are_where_the_kalman_recursion_ends(rate, tau_i):
    """Covariances by Van Loan's exponential, then prediction and correction until all stands."""
    axis = Axis(5.557, 6.6135, tau_i)
    specification = dataclasses.replace(SPECIFICATION, disturbance_rate=rate)
    found = design_velocity_filter(axis, T_S, specification)
    rates = np.array([[0, 1, 0], [0, -axis.b / axis.m, 1 / axis.m], [0, 0, 0]])
    white = np.diag([0.0, 0.0, rate**2])
    both = expm(np.block([[-rates, white], [np.zeros((3, 3)), rates.T]]) * T_S)
    A = both[3:, 3:].T
    held = A[:, 2] - [0.0, 0.0, 1.0]
    Q = A @ both[:3, 3:] + specification.force_noise**2 * np.outer(held, held)
    gain = kalman_gain(A, Q, np.diag([1e-12, 1e-6, 1.0]), 20000)
    np.testing.assert_allclose([found.L_x, found.L_v, found.L_d], gain, rtol=2e-3)


def test_gains_of_order_2_are_where_the_recursion_ends():
    """A force that is constant in each period and has a rate that wanders."""
    specification = dataclasses.replace(SPECIFICATION, disturbance_rate=300.0, order=2)
    found = design_velocity_filter(Axis(5.557, 6.6135), T_S, specification)
    rates = np.zeros((3, 3))
    rates[0, 1], rates[1, 1:] = 1.0, np.array([-6.6135, 1.0]) / 5.557
    move = expm(rates * T_S)
    A = np.vstack([np.hstack([move, T_S * move[:, 2:]]), [0.0, 0.0, 0.0, 1.0]])
    noise = np.append(move[:2, 2] * specification.force_noise, [0.0, 0.0])
    Q = np.outer(noise, noise) + np.diag([0.0, 0.0, 0.0, 300.0**2 * T_S])
    gain = kalman_gain(A, Q, np.diag([1e-12, 1e-6, 1.0, 1e4]), 3000)
    np.testing.assert_allclose([found.L_x, found.L_v, found.L_d, found.L_1], gain, rtol=1e-6)
    with pytest.raises(ControlError, match="order is 3 1; expected 1 or 2"):
        dataclasses.replace(specification, order=3)


@pytest.fixture(params=[(1e-4, 0.0), (1e-4, 5.557), (0.0, 5.557)], ids=str)
def filtered(request: pytest.FixtureRequest) -> VelocityLoop:
    tau_i, m_ff = request.param
    axis = Axis(5.557, 6.6135, tau_i)
    loop = design_velocity_loop(axis, LoopSpecification(125.0, 50.0, T_S, 5e-4))
    return loop.changed(m_ff=m_ff, velocity_filter=design_velocity_filter(axis, T_S, SPECIFICATION))


def test_without_friction_the_drive_is_the_nominal_loop(fmus, filtered):
    """A whole sweep: python-control's matrices in an FMU, and the loop of FMUs."""
    commands = filtered.commands(0.02 * np.sin(np.linspace(0.0, 9.0, 1001) ** 2))
    ideal = NO_FRICTION | {"encoder": 0, "dac": 0, "current_loop": filtered.axis.tau_i > 0.0}
    with build_loop(fmus, filtered, []).prepare(step=T_S, stop=0.5) as simulation:
        result = simulation.run({f"drive.{name}": x for name, x in ideal.items()}, commands)
    assert np.abs(result["controller.u"]).max() < 205.0
    error = result["drive.v"] - result["nominal.v_r"]
    assert np.abs(error).max() < 1e-7 * np.abs(result["drive.v"]).max()


def test_a_known_force_does_what_the_compliance_says(fmus, filtered):
    rng = np.random.default_rng(2)
    force = np.repeat(rng.normal(scale=10.0, size=41), 25)[:1001]
    system = ideal_servo(fmus, filtered)
    system.expose("F_ff", "controller.F_ff", "filter.F_ff")
    result = system.prepare(step=T_S, stop=0.5).run(inputs={"F_ff": force})
    C, A, B = filtered.compliance.C, filtered.compliance.A, filtered.compliance.B
    x, expected = np.zeros(len(A)), []
    for value in force:
        expected.append(C[0] @ x)
        x = A @ x + B[:, 0] * value
    assert np.abs(expected).max() > 1e-3
    np.testing.assert_allclose(result["drive.v"], expected, rtol=0, atol=1e-9)


def test_a_loop_is_designed_with_the_filter_in_it(filtered):
    """Crossover and margin are met by what stands in the loop: no lag but that of axis and hold."""
    wanted = LoopSpecification(150.0, 55.0, T_S)
    loop = design_velocity_loop(filtered.axis, wanted, velocity_filter=filtered.velocity_filter)
    figures = loop.margins()
    assert figures["crossover_Hz"] == pytest.approx(150.0, rel=1e-7)
    assert figures["phase_margin_deg"] == pytest.approx(55.0, abs=1e-5)
    z = np.exp(2j * np.pi * 150.0 * T_S)
    by_hand = (loop.K_p + loop.K_i * T_S * z / (z - 1)) * filtered.axis.sampled(T_S)(z)[1, 0]
    assert abs(by_hand) == pytest.approx(1.0, rel=1e-9)
    with pytest.raises(ControlError, match="out of reach"):
        design_velocity_loop(filtered.axis, dataclasses.replace(wanted, tau_f=5e-4))


def test_a_filter_of_another_sample_period_is_refused():
    axis = Axis(5.557, 6.6135, 1e-4)
    loop = design_velocity_loop(axis, LoopSpecification(125.0, 50.0, T_S, 5e-4))
    with pytest.raises(ControlError, match=r"velocity filter is 0.001 s; expected 0.0005"):
        loop.changed(velocity_filter=design_velocity_filter(axis, 1e-3, SPECIFICATION))
    second = dataclasses.replace(SPECIFICATION, order=2)
    with pytest.raises(ControlError, match=r"expected 0: a filter of order 1"):
        loop.changed(velocity_filter=design_velocity_filter(axis, T_S, second))
