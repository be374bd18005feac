"""Velocity and acceleration from a position, against polynomials."""

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
