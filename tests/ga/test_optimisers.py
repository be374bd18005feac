"""What holds for every optimiser, and what is special to one."""

import numpy as np
import pytest
from problems import GENES, TARGET, quadratic, sometimes_fails

from stickslip import ga

EVERY = pytest.mark.parametrize("algorithm", ga.ALGORITHMS)
HELD = ga.AtLeast("b", "a")


def learned(algorithm, cost=quadratic, evaluations=600, seed=0, repair=HELD, genes=GENES):
    limits = ga.Limits(evaluations=evaluations)
    optimiser = ga.optimiser(algorithm, ga.Problem(genes, repair), limits, seed)
    ga.learn(optimiser, cost)
    return optimiser


@EVERY
def test_candidates_keep_bounds_and_constraint(algorithm):
    history = learned(algorithm).history
    for gene in GENES:
        assert history[gene.name].between(gene.lower, gene.upper).all()
    assert (history["b"] >= history["a"]).all()


@EVERY
def test_the_start_is_the_first_candidate(algorithm):
    first = ga.optimiser(algorithm, ga.Problem(GENES)).ask()[0]
    span = np.array([gene.upper - gene.lower for gene in GENES])
    assert (np.abs(first - [gene.start for gene in GENES]) <= 0.51e-4 * span).all()


@EVERY
def test_the_same_seed_gives_the_same_bytes_and_leaves_numpy_alone(algorithm):
    before = np.random.get_state()[1].copy()  # noqa: NPY002 - this is the point
    histories = [learned(algorithm, evaluations=200, seed=s).history.to_csv() for s in (5, 5, 6)]
    assert histories[0] == histories[1] != histories[2]
    np.testing.assert_array_equal(np.random.get_state()[1], before)  # noqa: NPY002


@pytest.mark.parametrize("algorithm", ["default", "cma", "de"])
def test_it_finds_the_bottom_where_part_of_the_range_fails(algorithm):
    found = learned(algorithm, sometimes_fails, 1000).best
    np.testing.assert_allclose(found.values, np.minimum(TARGET, [2, np.inf, np.inf]), rtol=1e-2)


@pytest.mark.slow
def test_restarts_leave_a_trap():
    """A wide basin at the start that costs 1, and a narrow one far away that costs nothing."""

    def cost(values):
        away = np.log10(values / [0.2, 300.0, 5e-3])
        return float(min(1 + quadratic(values), 4 * (away @ away)))

    def median(**settings):
        limits = ga.Limits(evaluations=2000)
        runs = [
            ga.GeneticAlgorithm(GENES, ga.Settings(near_share=1.0, **settings), seed, limits=limits)
            for seed in range(3)
        ]
        return np.median([ga.learn(optimiser, cost).best.cost for optimiser in runs])

    assert median(patience=None) > 0.5
    assert median(patience=10, restarts=10) < 1e-6


@pytest.mark.parametrize(
    ("name", "genes", "message"),
    [
        ("magic", GENES, "no algorithm 'magic'; expected one of default, paper, cma, de"),
        ("cma", GENES[:1], "two genes or more"),
    ],
)
def test_what_cannot_be_is_named(name, genes, message):
    with pytest.raises(ga.SettingsError, match=message):
        ga.optimiser(name, ga.Problem(genes))
