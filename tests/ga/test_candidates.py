"""SimulatedCost, on a stand-in for cosim's Specification and on a real FMU."""

import pickle
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
import pytest
from problems import GENES, quadratic

from stickslip import cosim, ga

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
