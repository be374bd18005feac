"""Static friction and Stribeck velocity from a friction curve with known errors."""

import numpy as np
import pytest

from stickslip.identification.sliding.stribeck import EXPONENTS, rise

F_C, F_S, V_S, B = 6.0, 9.0, 1e-3, 20.0


def curve(speed: np.ndarray, delta: float, F_s: float = F_S) -> np.ndarray:
    return F_C + (F_s - F_C) * np.exp(-((speed / V_S) ** delta)) + B * speed


@pytest.mark.parametrize("delta", EXPONENTS)
def test_intervals_hold_the_values_of_a_curve_that_reaches_rest(delta: float) -> None:
    speed, rng = np.geomspace(0.3 * V_S, 40.0 * V_S, 12), np.random.default_rng(0)
    held = []
    for _ in range(40):
        value = curve(speed, delta) + 0.05 * rng.standard_normal(12)
        found = rise(speed, value, 0.05**2 * np.eye(12), delta)
        assert found is not None
        assert found.F_s[2] < 1.3 * found.F_s[1]
        held += [found.F_s[1] <= F_S <= found.F_s[2], found.v_s[1] <= V_S <= found.v_s[2]]
    assert np.mean(held) > 0.9


@pytest.mark.parametrize("lowest", [4.0 * V_S, 0.3 * V_S], ids=["too fast", "level"])
def test_what_a_curve_does_not_show_has_no_value(lowest: float) -> None:
    F_s = F_S if lowest > V_S else F_C
    speed = np.geomspace(lowest, 40.0 * V_S, 12)
    assert rise(speed, curve(speed, 1.0, F_s), 0.05**2 * np.eye(12), 1.0) is None


def test_another_exponent_explains_less_of_the_curve() -> None:
    speed = np.geomspace(0.3 * V_S, 40.0 * V_S, 12)
    right, wrong = (rise(speed, curve(speed, 2.0), 0.01**2 * np.eye(12), one) for one in (2.0, 1.0))
    assert right is not None
    assert wrong is None or wrong.deviance > 4.0 * right.deviance
