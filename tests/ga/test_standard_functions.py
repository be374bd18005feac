"""The algorithms on standard functions, whose lowest point and start follow a seed."""

import numpy as np
import pytest
from cma import ff
from scipy.optimize import differential_evolution

from stickslip import ga
from tests.kept import further

pytestmark = pytest.mark.slow

SEEDS, GENES = 5, 5


def ackley(z):
    wide = 20 * np.exp(-0.2 * np.sqrt(np.mean(z**2)))
    return float(20 + np.e - wide - np.exp(np.mean(np.cos(2 * np.pi * z))))


STANDARD = {  # a function of z, 0 at the origin; ends of the box of x; whether z is x rotated
    "ellipsoid, rotated": (ff.elli, 5.0, True),
    "Ackley, rotated": (ackley, 32.768, True),
    "Rastrigin": (ff.rastrigin, 5.12, False),
    "Rastrigin, rotated": (ff.rastrigin, 5.12, True),
}


def median(algorithm, function, budget):
    """Return the median over seeds of the lowest cost that is found within a budget."""
    value, end, rotated = STANDARD[function]
    found = []
    for seed in range(SEEDS):
        rng = np.random.default_rng([seed, GENES])
        start, lowest = rng.uniform(-end, end, GENES), rng.uniform(-0.6 * end, 0.6 * end, GENES)
        turn = np.linalg.qr(rng.standard_normal((GENES, GENES)))[0] if rotated else np.eye(GENES)

        def cost(x, turn=turn, lowest=lowest):
            return max(0.0, float(value(turn.T @ (x - lowest))))

        if algorithm == "random":
            found.append(min(map(cost, rng.uniform(-end, end, (budget, GENES)))))
            continue
        if algorithm == "scipy":  # two candidates a gene, generation after generation
            how = {"popsize": 2, "maxiter": budget // (2 * GENES) - 1, "tol": 0, "polish": False}
            box = [(-end, end)] * GENES
            found.append(differential_evolution(cost, box, x0=start, seed=seed, **how).fun)
            continue
        genes = [ga.Gene(f"x{i}", -end, end, x, linear=True) for i, x in enumerate(start)]
        optimiser = ga.optimiser(algorithm, ga.Problem(genes), ga.Limits(evaluations=budget), seed)
        found.append(ga.learn(optimiser, cost).best.cost)
    return float(np.median(found))


@pytest.mark.parametrize(
    "function", ["ellipsoid, rotated", *further("Rastrigin", "Ackley, rotated")]
)
def test_the_median_is_below_that_of_scipys_differential_evolution(function):
    assert median("default", function, 600) < median("scipy", function, 600)


@pytest.mark.parametrize(
    ("function", "below"), [("Rastrigin", 0.995), ("Rastrigin, rotated", GENES)]
)
def test_the_lowest_of_many_valleys_is_found(function, below):
    """The next valley of Rastrigin's function costs 0.995; rotated, each of some steps to it."""
    assert median("default", function, 1000) < below


@pytest.mark.parametrize("function", STANDARD)
def test_the_paper_learns_better_than_random_search(function):
    assert median("paper", function, 400) < median("random", function, 400)


@pytest.mark.parametrize("genes", [50, *further(30)])
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
