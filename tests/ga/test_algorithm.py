"""Laws of the algorithm, for both presets."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import GENES, quadratic

from stickslip import ga

PRESETS = pytest.mark.parametrize("preset", ga.PRESETS)


def run(algorithm, generations):
    for _ in range(generations):
        algorithm.tell([quadratic(row) for row in algorithm.ask()])
    return algorithm


def new(preset, seed=0, repair=None):
    return ga.GeneticAlgorithm(GENES, ga.PRESETS[preset], seed, repair)


@PRESETS
@settings(max_examples=15)
@given(seed=st.integers(0, 2**64), data=st.data())
def test_the_best_cost_never_rises_whatever_the_costs(preset, seed, data):
    algorithm = new(preset, seed)
    told = []
    for _ in range(6):
        n = len(algorithm.ask())
        cost = st.floats(0, 1e300) | st.just(float("inf")) | st.just(float("nan"))
        costs = data.draw(st.lists(cost, min_size=n, max_size=n))
        algorithm.tell(costs)
        told += [c for c in costs if c == c]
        assert algorithm.best.cost == min(told, default=float("inf"))
    best = algorithm.convergence()["best_cost"].to_numpy()
    assert (best[1:] <= best[:-1]).all()


def test_the_paper_searches_on_a_grid_of_its_resolution():
    algorithm = run(new("paper"), 5)
    for gene in GENES:
        string = (algorithm.history[gene.name] - gene.lower) / (gene.upper - gene.lower) / 1e-4
        np.testing.assert_allclose(string, string.round(), atol=1e-6)


@pytest.mark.parametrize("generations", [0, 7])
def test_a_state_between_ask_and_tell_is_that_before_ask(generations):
    """Threshold and number of generations may change; what is missing from a state is damage."""
    whole, broken = run(new("default", 4), 15), run(new("default", 4), generations)
    broken.ask()
    state = json.loads(json.dumps(broken.state(), allow_nan=False))
    longer = replace(ga.DEFAULT, generations=500, threshold=1e-9)
    resumed = ga.GeneticAlgorithm(GENES, longer, seed=4)
    resumed.replay(state)
    assert run(resumed, 15 - generations).history.to_csv() == whole.history.to_csv()
    del state["evaluations"]
    with pytest.raises(ga.StateError, match=r"damaged.*evaluations"):
        ga.GeneticAlgorithm(GENES, ga.DEFAULT, seed=4).replay(state)


def test_the_order_of_calls_is_enforced():
    algorithm = new("default")
    with pytest.raises(ga.CallOrderError, match="no best candidate yet"):
        _ = algorithm.best
    with pytest.raises(ga.CallOrderError, match="tell was called before ask"):
        algorithm.tell([])
    algorithm.ask()
    with pytest.raises(ga.CallOrderError, match="ask was called twice"):
        algorithm.ask()


@pytest.mark.parametrize(
    ("costs", "message"),
    [([1.0], "expects 10 costs"), ([[1.0] * 10], "expects 10"), ([-1.0] * 10, "0 or above")],
)
def test_costs_that_do_not_fit_are_refused_and_may_be_told_again(costs, message):
    algorithm = new("default")
    algorithm.ask()
    with pytest.raises(ga.CostError, match=message):
        algorithm.tell(costs)
    algorithm.tell(np.ones(10))
    assert algorithm.evaluations == 10


def test_a_cost_that_is_not_a_number_is_infinite_with_a_reason():
    algorithm = new("default")
    algorithm.ask()
    algorithm.tell([np.nan, np.inf, *np.ones(8)], ["", "it fell over", *[""] * 8])
    assert list(algorithm.history) == ["generation", "index", "a", "b", "c", "cost", "reason"]
    failed = algorithm.history[algorithm.history["cost"] == np.inf]
    assert list(failed["reason"]) == ["the cost is not a number", "it fell over"]
    assert algorithm.convergence().to_dict("records") == [
        {"generation": 1, "evaluations": 10, "best_cost": 1.0, "mean_cost": 1.0}
    ]
