"""The default on standard functions, against scipy on the same evaluations."""

import numpy as np
import pytest

from benchmarks.learning.contest import ackley, ellipsoid, rastrigin
from benchmarks.learning.racers import race_one, scipy_de
from stickslip import ga

pytestmark = pytest.mark.slow

BUDGET, SEEDS, GENES = 600, 5, 5


def median(found):
    return float(np.median(found))


def lowest_costs(cost, seeds, *, rotated=False, genes=GENES, budget=BUDGET, scipy=False):
    """Return what ours and, if asked for, scipy's evolution find on a box of +-5 for each seed."""
    ours, theirs = [], []
    for seed in range(seeds):
        rng = np.random.default_rng([seed, 7])
        bottom, start = rng.uniform(-3, 3, genes), rng.uniform(-5, 5, genes)
        turn = np.linalg.qr(rng.standard_normal((genes, genes)))[0] if rotated else np.eye(genes)

        def shifted(x, turn=turn, bottom=bottom):
            return max(0.0, cost(turn @ (x - bottom)))

        problem = ga.Problem(
            [ga.Gene(f"x{i}", -5, 5, float(x), linear=True) for i, x in enumerate(start)]
        )
        search = ga.optimiser("default", problem, ga.Limits(evaluations=budget), seed)
        ours.append(ga.learn(search, shifted).best.cost)
        assert search.evaluations <= budget
        if scipy:
            theirs.append(race_one(scipy_de(2), shifted, problem, seed, budget).best)
    return ours, theirs


@pytest.mark.parametrize(
    ("cost", "rotated"), [(rastrigin, False), (ackley, True), (ellipsoid, True)]
)
def test_the_median_is_below_that_of_scipy(cost, rotated):
    ours, theirs = lowest_costs(cost, SEEDS, rotated=rotated, scipy=True)
    assert median(ours) < median(theirs)


def test_the_lowest_of_many_valleys_is_found_where_genes_act_independently():
    """The next valley of Rastrigin's function costs 0.995."""
    ours, _ = lowest_costs(rastrigin, SEEDS, budget=1000)
    assert median(ours) < 0.995


def test_the_searches_anew_go_where_the_cost_is_lowest_by_and_large():
    """Each step to the next valley of a rotated Rastrigin function, in each gene, costs about 1."""
    ours, _ = lowest_costs(rastrigin, SEEDS, rotated=True, budget=1000)
    assert median(ours) < GENES


@pytest.mark.parametrize("genes", [30, 50])
def test_the_work_of_all_fits_is_bounded_in_many_dimensions(monkeypatch, genes):
    """Rows times the square of columns, which the time of least squares follows."""
    work = []
    solve = np.linalg.lstsq

    def counted(terms, *rest, **options):
        work.append(len(terms) * terms.shape[1] ** 2)
        return solve(terms, *rest, **options)

    monkeypatch.setattr("numpy.linalg.lstsq", counted)
    names = [ga.Gene(f"x{i}", -5, 5, 3.0, linear=True) for i in range(genes)]
    limits = ga.Limits(evaluations=700)
    found = ga.learn(ga.optimiser("default", ga.Problem(names), limits), lambda x: float(x @ x))
    assert found.best.cost < 1e-3  # from 9 a gene: the fits are of use
    assert sum(work) < 1e9
