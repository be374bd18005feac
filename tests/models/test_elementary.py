"""exp, log, sin and the phi functions against decimal arithmetic of 60 digits."""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import Decimal, localcontext

import numpy as np
import pytest

PI = Decimal("3.14159265358979323846264338327950288419716939937510582097494459230781640628620900")


def exact(function: Callable[[Decimal], Decimal], x: np.ndarray) -> list[Decimal]:
    with localcontext() as context:
        context.prec = 60
        return [function(Decimal(float(value))) for value in x]


def relative_error(y: np.ndarray, truth: list[Decimal]) -> float:
    """Return the largest error relative to the truth."""
    with localcontext() as context:
        context.prec = 60
        return max(
            float(abs((Decimal(float(a)) - b) / b)) for a, b in zip(y, truth, strict=True) if b
        )


def sine(x: Decimal) -> Decimal:
    half_turns = (x / PI).to_integral_value()
    r = x - half_turns * PI
    term = total = r
    for k in range(1, 25):
        term *= -r * r / (2 * k * (2 * k + 1))
        total += term
    return -total if half_turns % 2 else total


def phi(y: Decimal) -> Decimal:
    return (1 - (-y).exp()) / y


def phi2(y: Decimal) -> Decimal:
    return (1 - phi(y)) / y


RANDOM = np.random.default_rng(1)
POSITIVE = 10.0 ** RANDOM.uniform(-12, 4, 3000)
AROUND_A_HALF = np.nextafter(0.5, [0.0, 1.0, 0.5])

CASES = {
    "exp": (lambda x: x.exp(), RANDOM.uniform(-700, 700, 3000), 3e-16),
    "exp near 0": (lambda x: x.exp(), RANDOM.uniform(-2, 2, 3000), 3e-16),
    "log": (lambda x: x.ln(), 10.0 ** RANDOM.uniform(-300, 300, 3000), 3e-16),
    "log near 1": (lambda x: x.ln(), RANDOM.uniform(0.6, 1.6, 3000), 3e-16),
    "sin": (sine, RANDOM.uniform(-10, 10, 3000), 3e-16),
    "sin far out": (sine, RANDOM.uniform(-1e5, 1e5, 3000), 3e-16),
    "phi": (phi, np.concatenate([POSITIVE, AROUND_A_HALF]), 5e-16),
    "phi2": (phi2, np.concatenate([POSITIVE, AROUND_A_HALF]), 2e-15),
}


@pytest.mark.parametrize("case", CASES)
def test_relative_error_is_in_the_last_bits(c, case):
    function, x, bound = CASES[case]
    assert relative_error(c(case.split()[0], x), exact(function, x)) < bound


@pytest.mark.parametrize(
    ("name", "x", "y"),
    [
        ("exp", 0.0, 1.0),
        ("exp", -708.5, 0.0),
        ("exp", -math.inf, 0.0),
        ("log", 1.0, 0.0),
        ("sin", 0.0, 0.0),
        ("phi", 0.0, 1.0),
        ("phi2", 0.0, 0.5),
    ],
)
def test_special_values_are_exact(c, name, x, y):
    assert c(name, np.array([x]))[0] == y


def test_exp_stays_finite(c):
    assert np.isfinite(c("exp", np.array([709.0, 1e4, math.inf]))).all()


def test_what_is_not_a_number_stays_none(c):
    for name in ("exp", "phi", "phi2"):
        assert np.isnan(c(name, np.array([math.nan]))).all()


def test_symmetry(c):
    x = RANDOM.uniform(0, 50, 500)
    np.testing.assert_array_equal(c("sin", -x), -c("sin", x))
