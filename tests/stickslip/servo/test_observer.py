"""The design of a disturbance observer, and the sensitivity of the loop with it."""

from dataclasses import replace

import control
import numpy as np
import pytest

from stickslip.servo.axis import LOOP, Axis, ControlError
from stickslip.servo.observer import MASSES, design_observer
from stickslip.servo.sensitivity import OpenLoop, peak_sensitivity
from stickslip.servo.velocity_filter import FilterSpecification, design_velocity_filter
from stickslip.servo.velocity_loop import (
    LoopSpecification,
    VelocityLoop,
    close_velocity_loop,
    design_velocity_loop,
)
from stickslip.thresholds import offer
from tests.kept import further

PAPER = design_velocity_loop(Axis(5.557, 6.6135, 1e-4), LOOP)


def random_loop(rng: np.random.Generator) -> VelocityLoop:
    """Return a loop of an axis of 0.5 to 100 kg or of 0.01 to 100 g m2."""
    low, high = (0.5, 100.0) if rng.random() < 0.7 else (1e-5, 0.1)
    m = low * (high / low) ** rng.random()
    T_s = 1e-4 * 20.0 ** rng.random()
    tau_i = 0.0 if rng.random() < 0.2 else 5e-5 * 40.0 ** rng.random()
    bandwidth = rng.uniform(0.01, 0.06) / (T_s + tau_i)
    axis = Axis(m, m * rng.uniform(0.01, 3.0), tau_i)
    while True:
        try:
            return design_velocity_loop(axis, LoopSpecification(bandwidth, 50.0, T_s))
        except ControlError:
            bandwidth *= 0.7


@pytest.mark.parametrize("seed", [0, 1, *further(2, 3)])
def test_any_loop_gets_an_observer_within_the_limit(seed):
    """Also between the masses of the design, and at frequencies that it does not evaluate."""
    rng = np.random.default_rng(seed)
    loop = random_loop(rng)
    m = loop.axis.m
    step = 1e-9 * 5000.0 ** rng.random() * (1.0 if m > 0.1 else 1e3)
    friction = m * step / loop.T_s**2 * 10.0 ** rng.uniform(0.0, 2.0)  # visible to the encoder
    designed = design_observer(loop, step, friction)
    assert designed.reversal < 0.8 * designed.reversal_without
    w = 2 * np.pi * np.geomspace(1e-4, 0.5, 5000) / loop.T_s
    for share in (0.9, 0.97, 1.0, 1.06, 1.1):
        assert peak_sensitivity(loop, designed.observer, share * m) <= offer.SENSITIVITY * 1.001
    opened = OpenLoop(loop)
    opened.z = np.exp(1j * w * loop.T_s)
    u, x = by_feedback(loop, designed.observer, opened.z)
    assert max(np.abs(u).max(), np.abs(x).max()) <= offer.SENSITIVITY * 1.001


def by_feedback(loop, observer, z):
    """Return the sensitivity at command and encoder, from the closed loop by interconnection."""
    axis = loop.axis.sampled(loop.T_s)
    A = np.array(axis.A)
    A[-1, -1] = 0.0
    plant = control.ss(A, axis.B, np.eye(3)[[2, 0]], 0, loop.T_s, inputs="u", outputs=["d", "F"])
    estimate = control.ss(1, 0, 0, 1 / loop.T_s, loop.T_s, inputs="s", outputs="v_est")
    gains = loop.K_p, loop.T_s * loop.K_i
    pi = control.ss(1, gains[1], 1, sum(gains), loop.T_s, inputs="v_est", outputs="u_pi")
    kalman = observer.filter.disturbance()
    kalman = control.ss(kalman, inputs=["s", "F"], outputs="d_hat")
    parts = [
        plant,
        estimate,
        pi,
        kalman,
        control.summing_junction(["d", "n"], "s"),
        control.ss([], [], [], [[-1, -observer.share]], inputs=["u_pi", "d_hat"], outputs="c"),
        control.summing_junction(["c", "w"], "u"),
    ]
    closed = control.interconnect(parts, inputs=["w", "n"], outputs=["u", "s"])
    response = closed(z)
    return response[0, 0], response[1, 1]


def test_the_sensitivity_at_the_command_does_not_depend_on_an_exact_observer():
    observer = design_observer(PAPER, 4e-7, 6.0).observer
    alone, observed = OpenLoop(PAPER).response(), OpenLoop(PAPER).response(observer)
    np.testing.assert_allclose(observed.at_command, alone.at_command, rtol=1e-9)
    np.testing.assert_array_equal(alone.at_command, alone.at_encoder)
    low = OpenLoop(PAPER).f < 1.0
    assert (np.abs(observed.at_encoder[low]) < 0.1 * np.abs(alone.at_encoder[low])).all()
    silent = OpenLoop(PAPER).response(replace(observer, share=0.0))
    np.testing.assert_array_equal(silent.at_encoder, alone.at_encoder)


def test_a_velocity_filter_in_the_loop_counts_on_the_observers_force():
    """The known force goes to the filter, as ``build_loop`` connects it."""
    kalman = design_velocity_filter(PAPER.axis, PAPER.T_s, FilterSpecification(4e-7, 0.05, 1.5))
    loop = PAPER.changed(velocity_filter=kalman)
    opened = OpenLoop(loop)
    np.testing.assert_allclose(opened.response().at_command, 1 / (1 + loop.open_loop(opened.z)))
    designed = design_observer(loop, 4e-7, 6.0)
    assert designed.sensitivity <= offer.SENSITIVITY
    assert not np.isfinite(peak_sensitivity(loop, replace(designed.observer, share=50.0)))


def test_a_faster_observer_than_the_limit_allows_is_not_taken():
    """With an encoder that is all but exact, speed is limited by the mass alone."""
    designed = design_observer(PAPER, 1e-12, 600.0, force_noise=0.0, limit=1.9, masses=(1.0,))
    assert 1.7 < designed.sensitivity <= 1.9
    wider = design_observer(PAPER, 1e-12, 600.0, force_noise=0.0, masses=(0.8, 1.0, 1.25))
    assert wider.sensitivity <= offer.SENSITIVITY
    assert max(peak_sensitivity(PAPER, designed.observer, s * 5.557) for s in (0.8, 1.25)) > 1.9


def test_an_observer_of_order_2_is_designed_within_the_limit():
    designed = design_observer(PAPER, 4e-7, 6.0, order=2)
    assert designed.observer.filter.L_1 > 0.0
    assert designed.reversal < 0.5 * designed.reversal_without
    worst = max(peak_sensitivity(PAPER, designed.observer, s * 5.557) for s in MASSES)
    assert worst == pytest.approx(designed.sensitivity, rel=1e-6)
    assert worst <= offer.SENSITIVITY
    # a coarse encoder slows the observer
    rates = [design_observer(PAPER, q, 6.0).observer.filter.L_d for q in (1e-8, 4e-7, 2e-6)]
    assert rates[0] > 4 * rates[1] > 4 * rates[2]


def test_loops_without_room_for_an_observer_say_why():
    fast = close_velocity_loop(PAPER.axis, PAPER.T_s, PAPER.tau_f, 1.5 * PAPER.K_p, PAPER.K_i)
    assert peak_sensitivity(fast, m=min(MASSES) * fast.axis.m) > offer.SENSITIVITY
    with pytest.raises(ControlError, match=r"alone has a peak sensitivity of .*; lower K_p or K_i"):
        design_observer(fast, 4e-7, 6.0)
    swift = design_velocity_loop(Axis(60.0, 6.0), LoopSpecification(600.0, 40.0, 1.2e-4))
    with pytest.raises(
        ControlError, match=r"no disturbance observer .* the controller alone is as"
    ):
        design_observer(swift, 1e-6, 1.0)
    with pytest.raises(ControlError, match="friction is 0 N; expected above 0"):
        design_observer(PAPER, 1e-7, 0.0)
