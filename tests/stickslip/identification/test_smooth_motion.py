"""Velocity and acceleration from a position, against polynomials and the order of the formula."""

import numpy as np
import pytest

from stickslip.servo.measurement import derivative


@pytest.mark.parametrize("power", [1, 2, 3, 4])
def test_polynomials_up_to_the_fourth_degree_are_exact(power):
    t = np.linspace(1.0, 2.0, 101)
    slope = derivative(t**power, t[1] - t[0])
    exact = power * t ** (power - 1)
    np.testing.assert_allclose(slope[2:-2], exact[2:-2], rtol=1e-11)
    np.testing.assert_allclose(slope, exact, rtol=1e-9 if power == 1 else 0.05)


def test_the_error_is_of_fourth_order():
    errors = []
    for n in (50, 100, 200):
        t = np.linspace(0.0, 1.0, n + 1)
        errors.append(abs(derivative(np.sin(7 * t), 1 / n) - 7 * np.cos(7 * t))[2:-2].max())
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx(4.0, abs=0.1)
