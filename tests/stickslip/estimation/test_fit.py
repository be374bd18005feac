"""The fit against closed forms of linear least squares."""

import numpy as np
import pytest

from stickslip.identification.criteria.unknowns import NAMES, Unknowns
from stickslip.identification.fitting.fit import (
    covariance,
    fit,
    linearised,
)

N = 20_000


class Line:
    """A judge that is linear in the coordinates."""

    name, unit, used = "line", "m", slice(None)
    each = staticmethod(lambda function, items: [function(item) for item in items])

    def __init__(self, regressors, seen):
        self.regressors, self.seen = regressors, seen

    def residual(self, values):
        q = np.array([values["F_s"] / values["F_c"], *(values[name] for name in NAMES[1:6])])
        q = np.append(np.log(q), [values[name] for name in NAMES[6:]])
        return self.seen - self.regressors @ q


@pytest.fixture
def unknowns():
    n = len(NAMES)
    return Unknowns(
        1.0, 1.0, 1.0, np.zeros(n), np.full(n, np.inf), np.full(n, -9.0), np.full(n, 9.0)
    )


def judge(rng, truth, noise):
    regressors = rng.standard_normal((N, len(NAMES)))
    return Line(regressors, regressors @ truth + noise)


def test_it_finds_what_linear_least_squares_finds(unknowns):
    rng = np.random.default_rng(0)
    truth = rng.uniform(0.1, 1.0, len(NAMES))
    line = judge(rng, truth, 0.1 * rng.standard_normal(N))
    expected, *_ = np.linalg.lstsq(line.regressors, line.seen, rcond=None)
    found = fit(line, unknowns, np.zeros(len(NAMES)))
    np.testing.assert_allclose(found.q, expected, atol=1e-6)
    classic = 0.1**2 * np.linalg.inv(line.regressors.T @ line.regressors)
    np.testing.assert_allclose(np.diag(found.covariance), np.diag(classic), rtol=0.6)


def test_the_covariance_knows_of_correlated_noise(unknowns):
    """Slow noise on slow regressors: the plain formula says ten times too little."""
    spread, told = [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        slow = np.repeat(rng.standard_normal((N // 100, len(NAMES))), 100, axis=0)
        noise = np.repeat(rng.standard_normal(N // 100), 100)
        line = Line(slow, noise)
        q, *_ = np.linalg.lstsq(slow, noise, rcond=None)
        rest = noise - slow @ q
        spread.append(q[1])
        told.append(covariance(-slow, rest, unknowns)[1, 1])
        assert line is not None
    assert np.mean(told) == pytest.approx(np.var(spread), rel=0.5)


def test_what_is_expected_weighs_as_one_measurement():
    n = len(NAMES)
    doubt = np.full(n, np.inf)
    doubt[1] = 0.2
    expecting = Unknowns(1.0, 1.0, 1.0, np.full(n, 0.5), doubt, np.full(n, -9.0), np.full(n, 9.0))
    rng = np.random.default_rng(1)
    regressors = rng.standard_normal((N, n))
    regressors[:, 1] = 0.0  # the recording says nothing of it
    line = Line(regressors, regressors @ np.full(n, 0.3) + 0.1 * rng.standard_normal(N))
    found = fit(line, expecting, np.zeros(n))
    assert found.q[1] == pytest.approx(0.5, abs=1e-6)
    assert np.sqrt(found.covariance[1, 1]) == pytest.approx(0.2, rel=1e-3)


def test_a_gauss_step_of_a_linear_judge_leads_to_the_least_squares(unknowns):
    rng = np.random.default_rng(2)
    line = judge(rng, rng.uniform(0.1, 1.0, len(NAMES)), 0.1 * rng.standard_normal(N))
    expected, *_ = np.linalg.lstsq(line.regressors, line.seen, rcond=None)
    away = linearised(line, unknowns, expected + 0.01, 0.01)
    np.testing.assert_allclose(away.q + away.step(), expected, atol=1e-5)
