"""The default on standard functions, against scipy on the same evaluations."""

import numpy as np
import pytest

from benchmarks.learning.contest import STANDARD, Instance
from benchmarks.learning.racers import ours, race_one, scipy_de
from stickslip import ga

pytestmark = pytest.mark.slow

SEEDS, GENES = 5, 5
RASTRIGIN = STANDARD["Rastrigin"], STANDARD["Rastrigin, rotated"]


def median(racer, function, budget):
    """Return the median over seeds of the lowest cost that is found within a budget."""
    instances = [Instance(function, GENES, seed) for seed in range(SEEDS)]
    races = [race_one(racer, one, one.problem, k, budget) for k, one in enumerate(instances)]
    assert all(race.evaluations <= budget for race in races)
    return float(np.median([race.best for race in races]))


@pytest.mark.parametrize(
    "function", [RASTRIGIN[0], STANDARD["Ackley, rotated"], STANDARD["ellipsoid, rotated"]]
)
def test_the_median_is_below_that_of_scipy(function):
    assert median(ours, function, 600) < median(scipy_de, function, 600)


@pytest.mark.parametrize(("function", "below"), [(RASTRIGIN[0], 0.995), (RASTRIGIN[1], GENES)])
def test_the_lowest_of_many_valleys_is_found(function, below):
    """The next valley of Rastrigin's function costs 0.995; rotated, each of some steps to it."""
    assert median(ours, function, 1000) < below


def paper(evaluate, given, seed, budget):
    ga.learn(ga.optimiser("paper", given, ga.Limits(evaluations=budget), seed), evaluate)


def at_random(evaluate, given, seed, budget):
    ends = np.array([(gene.lower, gene.upper) for gene in given.genes]).T
    for values in np.random.default_rng(seed).uniform(*ends, (budget, len(given.genes))):
        evaluate(values)


@pytest.mark.parametrize("function", STANDARD.values(), ids=STANDARD)
def test_the_paper_learns_better_than_random_search(function):
    assert median(paper, function, 400) < median(at_random, function, 400)


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
