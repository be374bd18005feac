"""A 95 % interval holds the truth in 95 % of all recordings."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.catalog.parameters import ParameterSpace, friction_law
from stickslip.identification.fitting.fit import Fit
from stickslip.identification.fitting.identifiability import identifiability


@pytest.fixture
def fitted():
    space = ParameterSpace.of(friction_law())
    n = len(space.names)
    nothing = np.zeros(n)
    return Fit(space, nothing, np.zeros(1), np.zeros((1, n)), np.zeros((n, n)), 1.0)


@pytest.mark.parametrize("degrees", [3, 10, 1000])
@pytest.mark.parametrize("name", ["F_c", "b", "m"])
def test_the_truth_is_in_95_of_100_intervals(fitted, name, degrees):
    """The mean of normal numbers, and its standard error, from ``degrees + 1`` of them."""
    value = fitted.parameters[name]
    rng = np.random.default_rng(0)
    mean = rng.normal(0.0, 1.0 / np.sqrt(degrees + 1), 100_000)
    error = np.sqrt(rng.chisquare(degrees, 100_000) / degrees / (degrees + 1))
    scale = 1e-3 * abs(value) if value else 1e-3
    known = identifiability(name, fitted, dict.fromkeys(fitted.space.names, scale), degrees)
    if name != "b":
        below, above = np.log(value / known.low), np.log(known.high / value)
        factor = np.array([below, above]) * value / scale
    else:
        factor = np.array([value - known.low, known.high - value]) / scale
    below, above = factor[:, None] * error
    assert np.mean((mean > -below) & (mean < above)) == pytest.approx(0.95, abs=0.003)


def test_an_interval_ends_where_no_fit_may_go(fitted):
    """A value at its end is taken, written and exported, however little the recording shows."""
    space = replace(fitted.space, lower=np.full(len(fitted.q), -7.0), upper=fitted.q + 7.0)
    errors = dict.fromkeys(space.names, 1e6)
    known = identifiability("v_s", replace(fitted, space=space), errors, 10)
    assert (known.low, known.high) == pytest.approx((np.exp(-7.0), np.exp(7.0)))
