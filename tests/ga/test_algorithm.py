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


def run(algorithm, generations, cost=quadratic):
    for _ in range(generations):
        algorithm.tell([cost(row) for row in algorithm.ask()])
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


@PRESETS
@settings(max_examples=15)
@given(seed=st.integers(0, 2**32))
def test_candidates_stay_in_their_bounds(preset, seed):
    algorithm = run(new(preset, seed), 10)
    for gene in GENES:
        values = algorithm.history[gene.name]
        assert values.between(gene.lower, gene.upper).all()


@PRESETS
def test_the_start_is_the_first_candidate(preset):
    first = new(preset).ask()[0]
    span = np.array([gene.upper - gene.lower for gene in GENES])
    assert (np.abs(first - [gene.start for gene in GENES]) <= 0.51e-4 * span).all()


def test_the_paper_searches_on_a_grid_of_its_resolution():
    algorithm = run(new("paper"), 5)
    for gene in GENES:
        string = (algorithm.history[gene.name] - gene.lower) / (gene.upper - gene.lower) / 1e-4
        np.testing.assert_allclose(string, string.round(), atol=1e-6)


@PRESETS
def test_the_elite_is_not_evaluated_again(preset):
    algorithm = new(preset)
    assert algorithm.ask().shape == (10, 3)
    algorithm.tell(np.arange(10.0))
    assert algorithm.ask().shape == (8, 3)


@PRESETS
def test_the_same_seed_gives_the_same_bytes(preset):
    tables = [run(new(preset, seed), 15) for seed in (5, 5, 6)]
    histories = [table.history.to_csv() for table in tables]
    assert histories[0] == histories[1] != histories[2]
    assert tables[0].convergence().to_csv() == tables[1].convergence().to_csv()


@PRESETS
@pytest.mark.parametrize("asked", [False, True])
@pytest.mark.parametrize("generations", [0, 1, 7])
def test_a_resumed_run_equals_the_uninterrupted_one(preset, generations, asked):
    repair = ga.AtLeast("b", "a")
    whole = run(new(preset, 4, repair), 15, cost=_inf_beyond_10)
    broken = run(new(preset, 4, repair), generations, cost=_inf_beyond_10)
    if asked:
        broken.ask()
    text = json.dumps(broken.state(), allow_nan=False)
    resumed = ga.GeneticAlgorithm.from_state(
        GENES, ga.PRESETS[preset], json.loads(text), repair=repair
    )
    run(resumed, 15 - generations, cost=_inf_beyond_10)
    assert resumed.history.to_csv() == whole.history.to_csv()
    assert json.dumps(resumed.state()) == json.dumps(whole.state())


def _inf_beyond_10(values):
    return quadratic(values) if values[0] < 10 else float("inf")


def test_a_state_is_a_snapshot():
    algorithm = run(new("default"), 2)
    state = algorithm.state()
    text = json.dumps(state)
    run(algorithm, 2)
    assert json.dumps(state) == text


def test_a_resumed_run_may_go_on_for_longer_but_not_differently():
    state = run(new("default"), 2).state()
    longer = replace(ga.DEFAULT, generations=500, threshold=1e-9)
    assert ga.GeneticAlgorithm.from_state(GENES, longer, state).generation == 2
    with pytest.raises(ga.StateError, match="other settings"):
        ga.GeneticAlgorithm.from_state(GENES, ga.PAPER, state)
    with pytest.raises(ga.StateError, match="other genes"):
        ga.GeneticAlgorithm.from_state(GENES[:2], ga.DEFAULT, state)
    with pytest.raises(ga.StateError, match="no checkpoint"):
        ga.GeneticAlgorithm.from_state(GENES, ga.DEFAULT, {})
    del state["evaluations"]
    with pytest.raises(ga.StateError, match=r"damaged.*evaluations"):
        ga.GeneticAlgorithm.from_state(GENES, ga.DEFAULT, state)


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
    failed = algorithm.history[algorithm.history["cost"] == np.inf]
    assert list(failed["reason"]) == ["the cost is not a number", "it fell over"]
    assert algorithm.convergence()["mean_cost"].tolist() == [1.0]


@PRESETS
def test_a_cost_of_zero_is_survived(preset):
    algorithm = run(new(preset), 5, cost=lambda values: 0.0 if values[0] < 1 else 1.0)
    assert algorithm.best.cost == 0


def test_what_is_asked_and_best_are_the_callers_to_change():
    algorithm, twin = new("default"), new("default")
    asked = algorithm.ask()
    costs = [quadratic(row) for row in asked]
    asked[:] = 0
    algorithm.tell(costs)
    run(twin, 1)
    algorithm.best.values[:] = 0
    np.testing.assert_array_equal(algorithm.best.values, twin.best.values)


def test_tables_have_the_columns_that_files_promise():
    algorithm = run(new("paper"), 3)
    assert list(algorithm.history) == ["generation", "index", "a", "b", "c", "cost", "reason"]
    table = algorithm.convergence()
    assert list(table) == ["generation", "evaluations", "best_cost", "mean_cost"]
    assert table["generation"].tolist() == [1, 2, 3]
    assert table["evaluations"].tolist() == [10, 18, 26]
    assert (table["best_cost"] <= table["mean_cost"]).all()
