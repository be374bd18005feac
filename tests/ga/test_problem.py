"""Genes, settings, encoding and repair, and costs of simulations."""

import pickle
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from problems import GENES, quadratic

from stickslip import cosim, ga
from stickslip.ga.problem.problem import Encoding

UNIT = st.lists(st.floats(0, 1), min_size=3, max_size=3).map(lambda row: np.array([row]))


@pytest.mark.parametrize("kind", ["linear", "log"])
@given(strings=UNIT)
def test_decode_undoes_encode_within_the_bounds(kind, strings):
    encoding = Encoding(GENES, kind, None)
    values = encoding.decode(strings)
    assert (values >= encoding.lower).all()
    assert (values <= encoding.upper).all()
    np.testing.assert_allclose(encoding.encode(values), strings, atol=1e-12)


def test_log_gives_each_decade_the_same_room():
    values = Encoding(GENES, "log", None).decode(np.array([[0.0], [1 / 3], [2 / 3], [1.0]]))
    np.testing.assert_allclose(values[:, 0], [0.1, 1, 10, 100])


@pytest.mark.parametrize(
    ("resolution", "strings", "settled"),
    [
        (1e-4, [0.12344, 0.12346, 1.0], [0.1234, 0.1235, 1.0]),
        (0.3, [0.98, 0.8, -3.0], [0.9, 0.9, 0.0]),
        (None, [-0.2, 1.25, 0.5], [0.2, 0.75, 0.5]),  # mirrored at the ends
    ],
)
def test_strings_come_back_into_their_range_in_steps_of_the_resolution(
    resolution, strings, settled
):
    found = Encoding(GENES, "log", resolution).settle(np.array([strings]))
    np.testing.assert_allclose(found, [settled], atol=1e-15)


REPAIR = ga.AtLeast("b", "a")


@given(st.tuples(st.floats(0.1, 100), st.floats(0.6, 600), st.floats(1e-5, 1e-2)))
def test_the_constraint_and_the_bounds_hold(row):
    repaired = REPAIR(np.array([row]), GENES)[0]
    assert repaired[1] >= repaired[0]
    for value, gene in zip(repaired, GENES, strict=True):
        assert gene.lower <= value <= gene.upper


def test_a_candidate_that_keeps_the_constraint_is_left_alone():
    values = np.array([[2.0, 3.0, 1e-3], [3.0, 2.0, 1e-3]])
    np.testing.assert_array_equal(REPAIR(values, GENES), [[2.0, 3.0, 1e-3], [2.0, 3.0, 1e-3]])
    assert values[1, 0] == 3.0


NARROW = [ga.Gene("low", 0, 1, 0.5), ga.Gene("high", 2, 3, 2.5)]
SETTINGS = {"population": 3, "elite_rate": 1.0, "crossover_rate": np.nan, "near_spread": 0.0}
BOUNDS = {
    "lower must be below upper": (1.0, 1.0, 1.0),
    "start 2.0 is outside": (0.0, 1.0, 2.0),
    "upper must be finite": (0.0, np.inf, 1.0),
}


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Encoding([ga.Gene("x", 0.0, 1.0, 0.5)], "log", None),
            "gene x: log encoding needs a lower bound above 0",
        ),
        (
            lambda: ga.GeneticAlgorithm(GENES, repair=lambda values, _: values[0]).ask(),
            r"shape \(10, 3\), got \(3,\)",
        ),
        (lambda: ga.AtLeast("z", "a")(np.ones((1, 3)), GENES), "no gene 'z' among a, b, c"),
        (
            lambda: ga.AtLeast("low", "high")(np.array([[0.5, 2.5]]), NARROW),
            "low ends at 1, below the lower bound 2 of high",
        ),
        *(
            (partial(ga.Settings, **{field: value}), f"{field} must be .*, got")
            for field, value in [*SETTINGS.items(), ("crossover", "magic")]
        ),
        *((partial(ga.Gene, "F_c", *b), f"gene F_c: {said}") for said, b in BOUNDS.items()),
        *(
            (partial(ga.GeneticAlgorithm, genes), "each with its own name")
            for genes in ([], [GENES[0], GENES[0]])
        ),
        *(
            (partial(ga.Limits, **{field: -1}), f"{field} must be above 0, or None, got -1")
            for field in ("generations", "evaluations", "patience", "target")
        ),
        (
            partial(ga.optimiser, "magic", ga.Problem(GENES)),
            "no algorithm 'magic'; expected one of default, paper, cma",
        ),
        (partial(ga.optimiser, "cma", ga.Problem(GENES[:1])), "two genes or more"),
    ],
)
def test_what_cannot_be_is_named(make, message):
    with pytest.raises(ga.SettingsError, match=message):
        make()


CALLS = Counter()
NAMES = ("x.a", "x.b", "x.c")
SHORT = replace(ga.DEFAULT, generations=5)


class FakeSimulation:
    def run(self, parameters, inputs):
        CALLS["run"] += 1
        if parameters["x.a"] > 2:
            raise cosim.SimulationError("x: doStep failed at t = 1 s")
        return {"y": np.array([parameters[name] for name in NAMES]) * inputs["gain"]}

    def close(self):
        CALLS["close"] += 1


@dataclass(frozen=True)
class FakeSpecification:
    def prepare(self):
        CALLS["prepare"] += 1
        return FakeSimulation()


def judge(result):
    return quadratic(result["y"])


@pytest.fixture
def simulated():
    CALLS.clear()
    with ga.SimulatedCost(FakeSpecification(), NAMES, judge, {"gain": 1.0}) as cost:
        yield cost


def history(cost, executor=None):
    algorithm = ga.GeneticAlgorithm(GENES, SHORT)
    ga.learn(algorithm, cost, executor)
    return algorithm.history.to_csv()


def test_one_simulation_serves_all_candidates(simulated):
    history(simulated)
    assert CALLS == {"prepare": 1, "run": 42}
    simulated.close()
    assert CALLS["close"] == 1


def test_every_thread_has_its_own(simulated):
    serial = history(simulated)
    with ThreadPoolExecutor(2) as executor:
        assert history(simulated, executor) == serial
    assert 2 <= CALLS["prepare"] <= 3
    simulated.close()
    assert CALLS["close"] == CALLS["prepare"]


def test_copies_of_one_cost_share_a_simulation(simulated):
    simulated(np.ones(3))
    pickle.loads(pickle.dumps(simulated))(np.ones(3))  # noqa: S301 - our own bytes
    assert CALLS == {"prepare": 1, "run": 2}


def test_a_failed_run_is_a_failed_candidate(simulated):
    with pytest.raises(ga.CandidateFailed, match=r"x: doStep failed at t = 1 s"):
        simulated(np.array([3.0, 1.0, 1.0]))


def test_the_gene_that_decides_is_the_important_one():
    table = pd.DataFrame({"a": range(64), "b": [k * 37 % 64 for k in range(64)]}, dtype=float)
    for scale in (lambda x: x, lambda x: 10.0**x):  # ranks do not depend on the scale
        table["cost"] = [scale(abs(a - 20.0) / 10.0) for a in table["a"]]
        shares = ga.importances(table, ["b", "a"])
        assert list(shares) == ["a", "b"]
        assert shares["a"] > 0.8
        assert shares["b"] < 0.2
