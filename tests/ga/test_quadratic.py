"""Models of the cost: exact on paraboloids, careful elsewhere, of bounded work."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip.ga.operators.surrogates import RADIUS, Archive, bottom, bowl, unknowns


def paraboloid(k, seed):
    """Return a bottom (k,) and a cost function of random shape and tilt."""
    rng = np.random.default_rng(seed)
    lowest, root = rng.uniform(0.4, 0.6, k), rng.standard_normal((k, k)) + np.eye(k)
    return lowest, lambda x: 3.0 + np.sum(((x - lowest) @ root) ** 2, axis=1)


def ranked(points, costs):
    order = np.argsort(costs)
    return points[order], costs[order]


@settings(max_examples=25)
@given(k=st.integers(1, 6), seed=st.integers(0, 2**32))
def test_the_bottom_of_a_paraboloid_is_found_in_a_few_steps(k, seed):
    lowest, cost = paraboloid(k, seed)
    points = lowest + 0.05 * np.random.default_rng(seed + 1).standard_normal((2 * unknowns(k), k))
    for _ in range(3):  # one, unless it is farther than `RADIUS`
        points = np.vstack([points, bottom(*ranked(points, cost(points)))])
    assert cost(points)[-1] == pytest.approx(3.0, abs=1e-9)


def test_noise_is_averaged():
    lowest, cost = paraboloid(3, 1)
    rng = np.random.default_rng(2)
    errors = {}
    for n in (20, 2000):
        points = lowest + 0.05 * rng.standard_normal((n, 3))
        points, _ = ranked(points, cost(points))
        noise = 0.1 * np.std(cost(points)) * rng.standard_normal(n)
        errors[n] = np.linalg.norm(bottom(points, cost(points) + noise) - lowest)
    assert errors[2000] < 0.3 * errors[20]


@pytest.mark.parametrize("slope", [[1.0, 2.0], [-3.0, 0.0]])
@pytest.mark.parametrize("bend", [0.0, -4.0])
def test_where_there_is_no_bottom_it_goes_down_and_not_far(slope, bend):
    points = 0.5 + 0.1 * np.random.default_rng(0).standard_normal((30, 2))
    costs = 10 + points @ slope + bend * np.sum((points - 0.5) ** 2, axis=1)
    points, costs = ranked(points, costs)
    found = bottom(points, costs)
    spread = np.linalg.cholesky(np.cov(points, rowvar=False))
    assert np.linalg.norm(np.linalg.solve(spread, found - points[0])) <= RADIUS * (1 + 1e-6)
    assert 10 + found @ slope + bend * np.sum((found - 0.5) ** 2) < costs[0]


@pytest.mark.parametrize(
    "costs", [np.arange(6.0), np.full(30, 2.0), np.append(np.arange(6.0), np.full(24, np.inf))]
)
def test_what_cannot_be_said_is_not_said(costs):
    points = np.random.default_rng(0).random((len(costs), 2))
    assert bottom(points, costs) is None
    assert bottom(np.zeros_like(points), np.arange(len(costs), dtype=float)) is None


def test_an_archive_keeps_the_cheapest_in_order(monkeypatch):
    monkeypatch.setattr("stickslip.ga.operators.surrogates.ARCHIVED", 12)
    rng = np.random.default_rng(0)
    archive, added = Archive(2), []
    for _ in range(5):
        points = rng.random((8, 2))
        added.append(np.column_stack([points.sum(axis=1), points]))
        archive.add(points, points.sum(axis=1))
    cheapest = np.vstack(added)
    cheapest = cheapest[np.argsort(cheapest[:, 0])][:12]
    np.testing.assert_array_equal(archive.costs, cheapest[:, 0])
    np.testing.assert_array_equal(archive.strings, cheapest[:, 1:])


@settings(max_examples=25)
@given(k=st.integers(1, 8), seed=st.integers(0, 2**32))
def test_the_bottom_of_a_round_bowl_is_exact_wherever_the_points_are(k, seed):
    rng = np.random.default_rng(seed)
    lowest = rng.uniform(0.2, 0.8, k)
    points = np.vstack([rng.random((20, k)), 0.1 + 0.01 * rng.standard_normal((40, k))])
    costs = 3 + np.sum((points - lowest) ** 2, axis=1)
    np.testing.assert_allclose(bowl(*ranked(points, costs)), lowest, atol=1e-8)


def test_a_bowl_sees_past_ripples_that_trap_the_best_candidate_and_the_crowd_around_it():
    """Ripples as high as a third of the bowl, and most points in one of them."""
    rng = np.random.default_rng(0)
    lowest = np.full(3, 0.6)
    points = np.vstack([rng.random((100, 3)), 0.3 + 0.01 * rng.standard_normal((300, 3))])
    away = points - lowest
    costs = np.sum(away**2 + 0.05 * (1 - np.cos(2 * np.pi * away / 0.1)), axis=1)
    points, costs = ranked(points, costs)
    assert np.abs(bowl(points, costs) - lowest).max() < 0.05
    assert np.abs(points[0] - lowest).max() > 0.05


@pytest.mark.parametrize(
    "costs", [np.arange(4.0), np.full(30, 2.0), np.append(np.arange(4.0), np.full(24, np.inf))]
)
def test_there_is_no_bowl_through_too_few_or_equal_costs(costs):
    points = np.random.default_rng(0).random((len(costs), 2))
    assert bowl(points, costs) is None


def test_there_is_no_bowl_where_the_cost_bends_down():
    points = np.random.default_rng(0).random((30, 2))
    assert bowl(*ranked(points, 5 - np.sum((points - 0.5) ** 2, axis=1))) is None
