"""(8a), (8b), (9) and the measured velocity."""

import numpy as np
import pytest

from stickslip.evaluation.motions import REGION, regions_after
from stickslip.evaluation.validation import reduction, tracking_errors
from stickslip.servo.measurement import CUTOFF, measured_velocity, smoothed

T_S = 5e-4


def test_errors_count_inside_the_region_only():
    t = np.arange(2001) * T_S
    instant = 0.2
    inside = (t >= instant + REGION[0] - 1e-9) & (t <= instant + REGION[1] + 1e-9)
    (spans,) = regions_after({"start": instant}).values()
    assert tracking_errors(t, np.where(inside, 0.0, 9.0), spans)["E_max"] == 0.0
    error = np.zeros_like(t)
    error[np.flatnonzero(inside)[[0, -1]]] = 2.0
    found = tracking_errors(t, error, spans)
    assert found["E_max"] == 2.0
    assert found["E_rms"] == pytest.approx(np.sqrt(8.0 / inside.sum()))


def test_errors_over_several_spans_are_those_of_all_their_samples():
    t = np.arange(2001) * T_S
    error = np.where((t >= 0.1) & (t < 0.5), 1.0, -3.0)
    found = tracking_errors(t, error, [(0.1, 0.1 + 299 * T_S), (0.6, 0.6 + 99 * T_S)])
    assert found["E_max"] == 3.0
    assert found["E_rms"] == pytest.approx(np.sqrt((300 * 1.0 + 100 * 9.0) / 400))


def test_reduction_is_equation_9():
    assert reduction(0.98, 0.76) == pytest.approx(0.2245, abs=1e-4)
    assert reduction(2.0, 2.0) == 0.0


def test_measured_velocity_of_a_slow_sine_has_neither_lag_nor_loss():
    t = np.arange(8001) * T_S
    velocity = 2 * np.pi * 2.0 * 1e-3 * np.cos(2 * np.pi * 2.0 * t)
    shown = measured_velocity(1e-3 * np.sin(2 * np.pi * 2.0 * t), T_S)
    assert shown[1000:-1000] == pytest.approx(velocity[1000:-1000], abs=1e-5)


def test_the_low_pass_halves_the_power_twice_at_its_cutoff():
    t = np.arange(20001) * T_S
    passed = smoothed(np.sin(2 * np.pi * CUTOFF * t), T_S)[5000:-5000]
    assert np.abs(passed).max() == pytest.approx(0.5, rel=0.01)
