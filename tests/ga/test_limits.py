"""Every way to stop, and what is said then."""

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


def test_seconds_end_the_run():
    optimiser, why = run(ga.Limits(seconds=1e-9))
    assert optimiser.generation == 1
    assert why == "1e-09 s have passed"


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


@pytest.mark.parametrize("field", ["generations", "evaluations", "seconds", "patience", "target"])
def test_a_limit_out_of_range_is_named(field):
    with pytest.raises(ga.SettingsError, match=f"{field} must be above 0, or None, got -1"):
        ga.Limits(**{field: -1})


@pytest.mark.parametrize(
    ("limit", "name"),
    [("patience", "stagnant"), ("generations", "generations"), ("seconds", "seconds")],
)
def test_a_limit_is_reached_where_it_is_equalled(limit, name):
    done = {"generations": 1, "evaluations": 1, "batch": 1, "seconds": 0.0, "best": 1.0}
    limits = ga.Limits(**{limit: 10})
    assert limits.reached(**{**done, "stagnant": 0, name: 9}) is None
    assert limits.reached(**{**done, "stagnant": 0, name: 10}) is not None


def test_a_budget_may_be_used_to_the_last_evaluation():
    limits = ga.Limits(evaluations=10)
    assert limits.spent(generations=0, evaluations=6, batch=4) is None
    assert limits.spent(generations=0, evaluations=7, batch=4) is not None
