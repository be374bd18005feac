"""Learning runs: executors, failures, stopping, and how well it learns."""

from dataclasses import replace

import friction_sweep
import numpy as np
import pytest
from problems import GENES, always_fails, breaks, quadratic

from benchmarks.learning.racers import race_one, scipy_de
from stickslip import ga
from stickslip.ga.problem.problem import Encoding

SHORT = replace(ga.DEFAULT, generations=12)


def learned(settings, cost=quadratic, seed=0, executor=None):
    algorithm = ga.GeneticAlgorithm(GENES, settings, seed)
    return algorithm, ga.learn(algorithm, cost, executor)


def test_when_all_fail_the_first_reason_is_given():
    with pytest.raises(ga.NothingLearned, match=r"all 10 candidates failed.*no luck with 3 genes"):
        learned(SHORT, always_fails)


def crashes(error):
    """Return a cost that raises an error wherever gene a is large, but not at the start."""

    def cost(values):
        if values[0] > 2:
            raise error
        return quadratic(values)

    return cost


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (ZeroDivisionError("no force"), "ZeroDivisionError: no force"),
        (ga.CandidateFailed("no force"), "no force"),
    ],
)
def test_a_candidate_that_fails_costs_infinity_and_says_why(workers, error, reason):
    with ga.executor("threads", workers) as executor:
        algorithm, found = learned(SHORT, crashes(error), executor=executor)
    history = algorithm.history
    assert (history["cost"] == np.inf).tolist() == (history["a"] > 2).tolist()
    failed = history[history["cost"] == np.inf]
    assert (failed["reason"] == reason).all()
    assert len(failed) > 0
    assert found.best.cost < np.inf


def test_a_fault_of_the_machine_ends_the_run():
    with pytest.raises(FileNotFoundError):
        learned(SHORT, crashes(FileNotFoundError("drive.fmu")))
    cost = crashes(LookupError("no such variable"))
    cost.fatal = (LookupError,)
    with pytest.raises(LookupError):
        learned(SHORT, cost)


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_of_the_very_first_candidate_ends_the_run(workers):
    with ga.executor("threads", workers) as executor, pytest.raises(ZeroDivisionError):
        learned(SHORT, breaks, executor=executor)


def test_it_stops_at_the_threshold_or_the_last_generation():
    algorithm, found = learned(replace(ga.DEFAULT, threshold=1e-2))
    assert found.best.cost <= 1e-2
    assert algorithm.generation < 100
    assert "reached the threshold 0.01" in found.stopped
    algorithm, found = learned(SHORT)
    assert algorithm.generation == 12
    assert found.stopped == "all 12 generations are done"


SEEDS = range(12)
GENERATIONS = 50
BUDGET = 402  # evaluations of 50 generations; far beyond, all medians are below any drive's noise


@pytest.mark.slow
def test_on_friction_it_learns_at_least_as_well_as_differential_evolution():
    ours, theirs = [np.median([run(s) for s in SEEDS]) for run in (_learn, _evolve)]
    assert ours <= theirs
    assert ours < 1e-5


@pytest.mark.slow
def test_on_friction_the_paper_learns_better_than_random_search():
    ours = np.median([_learn(seed, ga.PAPER) for seed in SEEDS])
    assert ours < np.median([_draw(seed, ga.PAPER.encoding) for seed in SEEDS])


def _learn(seed, settings=ga.DEFAULT):
    algorithm = ga.GeneticAlgorithm(
        friction_sweep.genes(seed),
        replace(settings, generations=GENERATIONS),
        seed,
        friction_sweep.REPAIR,
    )
    best = ga.learn(algorithm, friction_sweep.ForceError()).best.cost
    assert algorithm.evaluations == BUDGET
    return best


def _evolve(seed):
    """Run scipy's differential evolution, given the same genes, start, repair and budget."""
    problem = ga.Problem(friction_sweep.genes(seed), friction_sweep.REPAIR)
    return race_one(scipy_de, friction_sweep.ForceError(), problem, seed, BUDGET).best


def _draw(seed, encoding):
    """Search at random from the same start, in the same encoding."""
    problem = ga.Problem(friction_sweep.genes(seed), friction_sweep.REPAIR)
    strings = np.random.default_rng(seed).random((BUDGET, 5))
    draws = Encoding(problem.genes, encoding, None).decode(strings)
    draws[0] = problem.start
    return min(map(friction_sweep.ForceError(), problem.repaired(draws)))
