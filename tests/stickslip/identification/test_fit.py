"""The fit against closed forms of linear least squares."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.catalog.parameters import ParameterSpace, friction_law
from stickslip.identification.fitting import fit as fitting
from stickslip.identification.fitting.fit import (
    BLOCKS,
    covariance,
    fit,
    inverse_information,
    linearised,
    plausible,
)

N = 20_000


K = len(ParameterSpace.of(friction_law()).names)


class Line:
    """A criterion that is linear in the coordinates."""

    name = "line"
    every = 1

    def __init__(self, regressors, seen, space):
        self.regressors, self.seen, self.space = regressors, seen, space

    def residual(self, values):
        return self.seen - self.regressors @ self.space.encode(values)

    def map(self, points):
        return [self.residual(values) for values in points]


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


def test_it_finds_what_linear_least_squares_finds(space):
    rng = np.random.default_rng(0)
    truth = rng.uniform(0.1, 1.0, K)
    line = line_of(rng, truth, 0.1 * rng.standard_normal(N), space)
    expected, *_ = np.linalg.lstsq(line.regressors, line.seen, rcond=None)
    found = fit(line, [np.zeros(K)])
    np.testing.assert_allclose(found.q, expected, atol=1e-6)
    classic = 0.1**2 * np.linalg.inv(line.regressors.T @ line.regressors)
    np.testing.assert_allclose(np.diag(found.covariance), np.diag(classic), rtol=0.6)


def test_correlations_of_values_are_those_of_draws(space):
    rng = np.random.default_rng(4)
    mixed = rng.standard_normal((K, K))
    line = line_of(rng, rng.uniform(0.1, 1.0, K), rng.standard_normal(N), space)
    found = replace(fit(line, [np.zeros(K)]), covariance=1e-8 * mixed @ mixed.T)
    draws = [list(values.values()) for values in plausible(found, 0, 4000)]
    names = list(found.parameters)
    expected = np.corrcoef([[v[names.index(name)] for v in draws[1:]] for name in space.names])
    np.testing.assert_allclose(found.correlations(), expected, atol=0.05)


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


def test_a_third_start_is_left_out_where_two_agree(space):
    rng = np.random.default_rng(4)
    line = line_of(rng, rng.uniform(0.1, 1.0, K), 0.1 * rng.standard_normal(N), space)

    def starts():
        yield np.zeros(K)
        yield np.ones(K)
        raise AssertionError("a third start was asked for")

    fit(line, starts())


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


def test_a_gauss_step_of_a_linear_criterion_leads_to_the_least_squares(space):
    rng = np.random.default_rng(2)
    line = line_of(rng, rng.uniform(0.1, 1.0, K), 0.1 * rng.standard_normal(N), space)
    expected, *_ = np.linalg.lstsq(line.regressors, line.seen, rcond=None)
    away = linearised(line, expected + 0.01, 0.01)
    np.testing.assert_allclose(away.q + away.step(), expected, atol=1e-5)
