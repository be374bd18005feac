"""The fit against closed forms, its intervals, and the derivatives that it is made from."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.catalog.parameters import ParameterSpace, friction_law
from stickslip.identification.criteria.runs import Criterion
from stickslip.identification.fitting import fit as fitting
from stickslip.identification.fitting.fit import (
    BLOCKS,
    Fit,
    covariance,
    fit,
    inverse_information,
    linearised,
)
from stickslip.identification.fitting.identifiability import identifiability
from stickslip.servo.measurement import derivative

N = 20_000
K = len(ParameterSpace.of(friction_law()).names)


class Line(Criterion):
    """A criterion that is linear in the coordinates."""

    every = 1

    def __init__(self, regressors, seen, space):
        self.regressors, self.seen, self.space = regressors, seen, space

    def residual(self, values):
        return self.seen - self.regressors @ self.space.encode(values)


@pytest.fixture
def space():
    bound = np.full(K, 9.0)
    return replace(ParameterSpace.of(friction_law()), lower=-bound, upper=bound)


def line_of(rng, truth, noise, space):
    regressors = rng.standard_normal((N, K))
    return Line(regressors, regressors @ truth + noise, space)


def test_what_has_no_information_but_rounding_has_a_large_variance(space, monkeypatch):
    """In the sums of a log of 20,000 samples that slides one way, rounding was 4e-15."""
    jacobian = np.random.default_rng(0).standard_normal((500, K))
    jacobian[:, 0] = 0.0
    rounding = np.zeros(K)
    rounding[0] = -4e-15 * np.linalg.eigvalsh(jacobian.T @ jacobian)[-1]
    monkeypatch.setattr(fitting, "_prior_information", lambda _: rounding)
    variance = np.diag(inverse_information(jacobian, 1.0, space))
    assert variance[0] > 1e9
    told = np.linalg.inv(jacobian[:, 1:].T @ jacobian[:, 1:])
    np.testing.assert_allclose(variance[1:], np.diag(told), rtol=1e-9)


def test_what_nothing_depends_on_is_not_certain(space, monkeypatch):
    monkeypatch.setattr(fitting, "_prior_information", lambda _: np.zeros(K))
    rng = np.random.default_rng(0)
    jacobian, rest = rng.standard_normal((500, K)), rng.standard_normal(500)
    jacobian[:, 0] = 0.0
    for found in (inverse_information(jacobian, 1.0, space), covariance(jacobian, rest, space)):
        deviations = np.sqrt(np.diag(found))
        assert deviations[0] > 5.0  # the factor of a value is e to this power
        assert np.all(deviations[1:] < 0.2)
        assert not np.any(found[0, 1:])


def test_it_finds_what_linear_least_squares_finds_from_two_starts_that_agree(space):
    def starts():
        yield np.zeros(K)
        yield np.ones(K)
        raise AssertionError("a third start was asked for")

    rng = np.random.default_rng(0)
    truth = rng.uniform(0.1, 1.0, K)
    line = line_of(rng, truth, 0.1 * rng.standard_normal(N), space)
    expected, *_ = np.linalg.lstsq(line.regressors, line.seen, rcond=None)
    found = fit(line, starts())
    np.testing.assert_allclose(found.q, expected, atol=1e-6)
    away = linearised(line, expected + 0.01, 0.01)
    np.testing.assert_allclose(away.q + away.step(), expected, atol=1e-5)
    classic = 0.1**2 * np.linalg.inv(line.regressors.T @ line.regressors)
    np.testing.assert_allclose(np.diag(found.covariance), np.diag(classic), rtol=0.6)


def test_a_step_is_run_beside_the_slopes_that_follow_it(space):
    """Most steps succeed, and lanes run ten candidates in the time of one."""
    line = line_of(rng := np.random.default_rng(2), rng.uniform(0.1, 1.0, K), 0.1, space)
    known, new = set(), []

    def run(points):
        asked = {tuple(values.values()) for values in points}
        new.append(len(asked - known))
        known.update(asked)

    line.run = run
    fit(line, [np.zeros(K)])
    assert {*new} == {0, K + 1}  # what slopes ask for has been run
    assert new.count(0) >= 2


def test_a_coordinate_that_leaves_its_bounds_stops_there(space):
    """The others are then those of least squares with the held one moved to the other side."""
    rng = np.random.default_rng(1)
    truth = rng.uniform(0.1, 1.0, K)
    line = line_of(rng, truth, 0.1 * rng.standard_normal(N), space)
    held, free = 3, np.arange(K) != 3
    line.space = replace(space, upper=np.where(free, 9.0, 0.05))
    rest = line.seen - 0.05 * line.regressors[:, held]
    expected, *_ = np.linalg.lstsq(line.regressors[:, free], rest, rcond=None)
    found = fit(line, [np.zeros(K)])
    assert found.q[held] == pytest.approx(0.05, abs=1e-6)
    np.testing.assert_allclose(found.q[free], expected, atol=1e-5)


@pytest.mark.slow
def test_the_covariance_knows_of_correlated_noise(space):
    """Slow noise on slow regressors: the plain formula says ten times too little."""
    spread, told = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        slow = np.repeat(rng.standard_normal((N // 100, K)), 100, axis=0)
        noise = np.repeat(rng.standard_normal(N // 100), 100)
        q, *_ = np.linalg.lstsq(slow, noise, rcond=None)
        rest = noise - slow @ q
        spread.append(q[1])
        told.append(covariance(-slow, rest, space)[1, 1])
    assert np.mean(told) == pytest.approx(np.var(spread), rel=0.5)


def test_the_covariance_is_not_too_small_on_average(space):
    """White noise, whose covariance has a closed form; a fit takes away degrees of freedom."""
    rng = np.random.default_rng(3)
    regressors = rng.standard_normal((1000, K))
    exact = np.diag(np.linalg.inv(regressors.T @ regressors))
    told = []
    for _ in range(300):
        noise = rng.standard_normal(1000)
        rest = noise - regressors @ np.linalg.lstsq(regressors, noise, rcond=None)[0]
        told.append(np.diag(covariance(-regressors, rest, space)) / exact)
    assert 1.01 < np.mean(told) < BLOCKS / (BLOCKS - K) + 0.03


def test_a_prior_weighs_as_one_measurement(space):
    deviation = np.full(K, np.inf)
    deviation[1] = 0.2
    prior = replace(space, prior_mean=np.full(K, 0.5), prior_deviation=deviation)
    rng = np.random.default_rng(1)
    regressors = rng.standard_normal((N, K))
    regressors[:, 1] = 0.0  # the recording says nothing of it
    line = Line(regressors, regressors @ np.full(K, 0.3) + 0.1 * rng.standard_normal(N), prior)
    found = fit(line, [np.zeros(K)])
    assert found.q[1] == pytest.approx(0.5, abs=1e-6)
    assert np.sqrt(found.covariance[1, 1]) == pytest.approx(0.2, rel=1e-3)


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


@pytest.mark.parametrize("power", [1, 2, 3, 4])
def test_polynomials_up_to_the_fourth_degree_are_exact(power):
    t = np.linspace(1.0, 2.0, 101)
    slope = derivative(t**power, t[1] - t[0])
    exact = power * t ** (power - 1)
    np.testing.assert_allclose(slope[2:-2], exact[2:-2], rtol=1e-11)
    np.testing.assert_allclose(slope, exact, rtol=1e-9 if power == 1 else 0.05)
