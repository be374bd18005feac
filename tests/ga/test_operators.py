"""The operators: parents, survivors, rates that follow success, sections, models of the cost."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stickslip import ga
from stickslip.ga.algorithms.genetic import Generation
from stickslip.ga.operators.breeding import LEAST, MutationRate, Shares, arithmetic, differential
from stickslip.ga.operators.surrogates import RADIUS, Sections, bottom, bowl, unknowns

N = 20
LABELS = np.arange(N, dtype=float)[:, np.newaxis]  # a string names its candidate


def test_parents_are_drawn_in_proportion_to_their_fitness():
    """Where none is crossed, children are copies: of each as many as the inverse of its cost."""
    settings = replace(ga.PAPER, population=N, k1=0.0, k2=0.0)
    costs = np.linspace(1.0, 20.0, N)
    rng = np.random.default_rng(0)
    drawn = [arithmetic(LABELS, costs, settings, rng) for _ in range(2000)]
    counts = np.bincount(np.concatenate(drawn).astype(int).ravel(), minlength=N)
    share = (1.0 / costs) / (1.0 / costs).sum()
    deviation = np.sqrt(counts.sum() * share)
    assert abs(counts - counts.sum() * share).max() < 4.5 * deviation.max()
    assert np.mean(((counts - counts.sum() * share) / deviation) ** 2) < 2.0


def test_a_difference_is_of_two_others(monkeypatch):
    """The parent itself is not among them; the origin is the best one in 70 % of all children."""
    monkeypatch.setattr("stickslip.ga.operators.breeding.STRETCH", (1.0, 1.0))
    settings = replace(ga.DEFAULT, population=N, crossover_rate=1.0)
    strings = 3.0 ** np.arange(N)[:, np.newaxis]  # so that a child shows what it is the sum of
    rng, n = np.random.default_rng(2), np.arange(N)
    origin, plus, minus = (axis.ravel() for axis in np.meshgrid(n, n, n, indexing="ij"))
    sums = 3.0**origin + 3.0**plus - 3.0**minus
    best = []
    for _ in range(40):
        children = differential(strings, np.zeros(N), settings, rng)
        for place, child in enumerate(children[:, 0], start=settings.elites):
            found = (sums == child) & (plus != minus) & (plus != place) & (minus != place)
            assert found.any()
            best.append(bool((origin[found] == 0).any()))
    assert np.mean(best) == pytest.approx(0.7, abs=0.08)


INF = float("inf")


def generation(costs):
    strings = np.arange(len(costs), dtype=float)[:, np.newaxis]
    return Generation(strings, np.array(costs))


def test_a_child_takes_the_place_of_a_rival_that_is_not_better():
    settings = replace(ga.DEFAULT, population=6, survival="rival")
    parents = generation([1.0, 2.0, 3.0, 4.0, INF, INF])
    rivals = parents.costs[settings.elites :]
    children = generation(np.where(np.arange(len(rivals)) % 2, rivals, rivals + 1.0))
    wins = parents.winners(children, settings)
    assert wins.tolist() == (children.costs <= rivals).tolist()
    kept = parents.followed_by(children, wins)
    assert (kept.costs == parents.costs).all()  # those that win cost the same here
    everyone = replace(settings, survival="generational")
    assert parents.winners(children, everyone).all()


def probability(parents, best=4.0, mean=2.0, k1=0.9, k2=0.7):
    return ga.crossover_probability(np.array(parents), best=best, mean=mean, k1=k1, k2=k2)


def test_values_of_equation_7():
    np.testing.assert_allclose(
        probability([4.0, 3.0, 2.5, 2.0, 1.9, 0.0]), [0.0, 0.45, 0.675, 0.9, 0.7, 0.7]
    )
    np.testing.assert_array_equal(probability([2.0, 2.0], best=2.0), [0.7, 0.7])  # all are equal


@given(
    costs=st.lists(st.floats(0, 1e300) | st.just(float("inf")), min_size=4, max_size=12),
    k1=st.floats(0, 1),
    k2=st.floats(0, 1),
)
def test_it_is_a_probability_for_any_generation(costs, k1, k2):
    J = ga.fitness(np.array(costs))
    P_c = ga.crossover_probability(J, best=J.max(), mean=J.mean(), k1=k1, k2=k2)
    assert ((P_c >= 0) & (P_c <= max(k1, k2) * (1 + 1e-9))).all()


@pytest.mark.parametrize(
    ("costs", "expected"),
    [([2.0, 4.0, np.inf], [1, 0.5, 0]), ([0.0, 1.0, 0.0], [1, 0, 1]), ([np.inf, np.inf], [1, 1])],
)
def test_fitness_is_the_inverse_of_cost_as_a_fraction_of_the_best(costs, expected):
    np.testing.assert_array_equal(ga.fitness(np.array(costs)), expected)


def drawn(rate, n=2000):
    return rate.draw(n, np.random.default_rng(0))


def test_it_moves_to_the_rates_that_succeeded():
    rate = MutationRate(ga.Settings(mutation_rate=0.3))
    before = drawn(rate)
    assert before.mean() == pytest.approx(0.3, abs=0.01)
    assert (before >= 0).all()
    for _ in range(20):
        rates = drawn(rate)
        rate.follow(rates, rates[:, 0] > np.quantile(rates, 0.9))
    assert drawn(rate).mean() > 0.4
    level = drawn(rate)
    rate.follow(level, np.zeros(len(level), dtype=bool))
    np.testing.assert_array_equal(drawn(rate), level)


def test_shares_follow_the_way_that_succeeds_more_often_and_none_dies_out():
    shares, rng = Shares((5, 1, 1)), np.random.default_rng(0)
    assert np.argmax(shares.shares) == 0
    chances = np.array([0.02, 0.4, 0.0])
    for _ in range(60):
        ways = shares.draw(7, rng)
        shares.follow(ways, rng.random(7) < chances[ways])
    assert shares.shares.sum() == pytest.approx(1)
    assert shares.shares[1] > 0.6
    assert (shares.shares >= LEAST).all()


def separable(string):
    """Return a sum over genes, each with several minima; the lowest, 0, at 0.7."""
    away = 10 * (string - 0.7)
    return float(np.sum(away**2 + 5 * (1 - np.cos(2 * np.pi * away))))


def searched(cost, start, generations, children=4, seed=0):
    """Return every candidate and its cost, the best one moved to after each generation."""
    rng = np.random.default_rng(seed)
    best, lowest = np.array(start), cost(np.array(start))
    sections, rows = Sections(best, lowest), []
    for _ in range(generations):
        strings = sections.propose(children, rng)
        costs = [cost(string) for string in strings]
        for string, value in zip(strings, costs, strict=True):
            sections.add(string, value)
            rows.append((string, value))
        if min(costs) < lowest:
            lowest, best = min(costs), strings[int(np.argmin(costs))]
            sections.move(best, lowest)
    return sections, rows


def test_a_sum_of_many_valleys_is_solved_gene_by_gene():
    """The grid of its minima has 11 ** 5 points."""
    _, rows = searched(separable, np.full(5, 0.13), 80)
    assert min(cost for _, cost in rows) < 1e-3


def test_what_improves_two_genes_apart_is_put_together():
    sections = Sections(np.array([0.5, 0.5, 0.5]), 5.0)
    sections.add(np.array([0.2, 0.5, 0.5]), 4.0)
    sections.add(np.array([0.5, 0.9, 0.5]), 3.0)
    rng = np.random.default_rng(0)
    np.testing.assert_array_equal(sections.propose(1, rng)[0], [0.2, 0.9, 0.5])
    sections.add(np.array([0.2, 0.9, 0.5]), 30.0)  # the genes do not act independently
    assert not np.array_equal(sections.propose(1, rng)[0], [0.2, 0.9, 0.5])


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
    ("model", "costs"),
    [
        (bottom, np.arange(6.0)),
        (bottom, np.append(np.arange(6.0), np.full(24, np.inf))),
        (bottom, np.full(30, 2.0)),
        (bowl, np.arange(4.0)),
        (bowl, np.append(np.arange(4.0), np.full(24, np.inf))),
        (bowl, np.full(30, 2.0)),
    ],
)
def test_too_few_or_equal_costs_have_no_model(model, costs):
    points = np.random.default_rng(0).random((len(costs), 2))
    assert model(points, costs) is None


def test_there_is_no_bottom_through_one_point_and_no_bowl_where_the_cost_bends_down():
    assert bottom(np.zeros((30, 2)), np.arange(30.0)) is None
    points = np.random.default_rng(0).random((30, 2))
    assert bowl(*ranked(points, 5 - np.sum((points - 0.5) ** 2, axis=1))) is None


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
