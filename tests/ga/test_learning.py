"""Learning runs: executors, failures and stopping."""

from dataclasses import replace

import numpy as np
import pytest
from problems import GENES, always_fails, breaks, quadratic

from stickslip import ga

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
