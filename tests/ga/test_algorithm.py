"""Laws of every optimiser: order of calls, seeds, costs, failures and the end of a run."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from problems import GENES, TARGET, always_fails, breaks, quadratic, sometimes_fails

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


@pytest.mark.parametrize("algorithm", ["default", "cma"])
def test_it_finds_the_bottom_where_part_of_the_range_fails(algorithm):
    found = learned(algorithm, sometimes_fails, 1000).best
    np.testing.assert_allclose(found.values, np.minimum(TARGET, [2, np.inf, np.inf]), rtol=1e-2)


SHORT = replace(ga.DEFAULT, generations=12)


def ended(settings, cost=quadratic, seed=0, executor=None):
    algorithm = ga.GeneticAlgorithm(GENES, settings, seed)
    return algorithm, ga.learn(algorithm, cost, executor)


def test_when_all_fail_the_first_reason_is_given():
    with pytest.raises(ga.NothingLearned, match=r"all 10 candidates failed.*no luck with 3 genes"):
        ended(SHORT, always_fails)


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
        algorithm, found = ended(SHORT, crashes(error), executor=executor)
    history = algorithm.history
    assert (history["cost"] == np.inf).tolist() == (history["a"] > 2).tolist()
    failed = history[history["cost"] == np.inf]
    assert (failed["reason"] == reason).all()
    assert len(failed) > 0
    assert found.best.cost < np.inf


def test_a_fault_of_the_machine_ends_the_run():
    with pytest.raises(FileNotFoundError):
        ended(SHORT, crashes(FileNotFoundError("drive.fmu")))
    cost = crashes(LookupError("no such variable"))
    cost.fatal = (LookupError,)
    with pytest.raises(LookupError):
        ended(SHORT, cost)


@pytest.mark.parametrize("workers", [1, 2])
def test_an_error_of_the_very_first_candidate_ends_the_run(workers):
    with ga.executor("threads", workers) as executor, pytest.raises(ZeroDivisionError):
        ended(SHORT, breaks, executor=executor)
