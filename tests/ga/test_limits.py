"""Every way to stop, and generations that are known before the costs of the one before."""

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from problems import GENES, quadratic

from stickslip import ga


def run(limits, cost=quadratic, algorithm="default"):
    optimiser = ga.optimiser(algorithm, ga.Problem(GENES), limits)
    return optimiser, ga.learn(optimiser, cost).stopped


@pytest.mark.parametrize("algorithm", ga.ALGORITHMS)
def test_a_budget_of_evaluations_is_never_exceeded(algorithm):
    for budget in (30, 101):
        optimiser, why = run(ga.Limits(evaluations=budget), algorithm=algorithm)
        assert budget - optimiser.batch < optimiser.evaluations <= budget
        assert f"the budget of {budget} evaluations is used" in why


@pytest.mark.parametrize("algorithm", ga.ALGORITHMS)
def test_a_target_ends_the_run_as_soon_as_it_is_reached(algorithm):
    optimiser, why = run(ga.Limits(evaluations=2000, target=0.5), algorithm=algorithm)
    costs = optimiser.convergence().best_cost.to_numpy()
    assert costs[-1] <= 0.5
    assert (costs[:-1] > 0.5).all()
    assert "reached the threshold 0.5" in why


@pytest.mark.parametrize("algorithm", ga.ALGORITHMS)
def test_stagnation_ends_the_run(algorithm):
    limits = ga.Limits(evaluations=2000, patience=60)
    optimiser, why = run(limits, lambda values: 1.0 + 1e-3 * quadratic(values), algorithm)
    assert 60 <= optimiser.evaluations < 200
    assert why.startswith("stagnation: the best cost has not fallen by 1 % in ")


def test_a_search_at_rest_begins_anew_and_then_ends():
    settings = ga.Settings(patience=5, restarts=2)
    optimiser = ga.GeneticAlgorithm(GENES, settings, 1, limits=ga.Limits(evaluations=10_000))
    why = ga.learn(optimiser, lambda values: 1.0 + 1e-3 * quadratic(values)).stopped
    assert why.startswith("stagnation: ")
    assert why.endswith("after 2 restarts")
    anew = optimiser.history.groupby("generation").size().to_numpy() == 10
    assert anew.sum() == 3


def test_a_collapsed_population_is_at_rest():
    settings = ga.Settings(patience=10_000, restarts=0)
    optimiser = ga.GeneticAlgorithm(GENES, settings, 1, limits=ga.Limits(evaluations=10_000))
    why = ga.learn(optimiser, quadratic).stopped
    assert "collapsed" in why
    assert optimiser.best.cost < 1e-20
    assert optimiser.evaluations < 1000


def optimiser(settings=ga.PRESETS["default"], **limits):
    return ga.GeneticAlgorithm(GENES, settings, limits=ga.Limits(**limits))


def test_a_fresh_start_forgets_what_was_foreseen():
    settings = replace(ga.PRESETS["default"], patience=1)
    algorithm, forgotten = optimiser(settings, generations=30), set()
    for _ in range(12):
        asked, foreseen = algorithm.ask(), algorithm.ahead
        assert forgotten.isdisjoint(row.tobytes() for row in asked)
        algorithm.tell([1.0] * len(asked))
        if algorithm.batch == settings.population:
            forgotten |= {row.tobytes() for row in foreseen}
    assert len(forgotten) > settings.population


def test_a_worker_goes_on_while_the_last_cost_is_missing():
    """A candidate of the fourth generation ends only when one of the fifth has begun."""
    plan = optimiser(generations=9)
    for _ in range(3):
        plan.tell([quadratic(values) for values in plan.ask()])
    slow = plan.ask()[0].tobytes()
    next_ones = {values.tobytes() for values in plan.ahead}
    begun = threading.Event()

    def cost(values):
        if values.tobytes() in next_ones:
            begun.set()
        if values.tobytes() == slow:
            assert begun.wait(timeout=30), "nothing of the next generation was begun"
        return quadratic(values)

    with ThreadPoolExecutor(2) as threads:
        algorithm = optimiser(generations=6)
        ga.learn(algorithm, cost, threads)
    assert begun.is_set()
    assert np.isfinite(algorithm.history["cost"]).all()


@pytest.mark.parametrize("limits", [{"generations": 5}, {"evaluations": 45}])
def test_nothing_is_begun_that_the_limits_forbid(limits):
    evaluated = []

    def cost(values):
        evaluated.append(values.tobytes())
        return quadratic(values)

    with ThreadPoolExecutor(2) as threads:
        algorithm = optimiser(**limits)
        ga.learn(algorithm, cost, threads)
    assert len(evaluated) == algorithm.evaluations == 42
