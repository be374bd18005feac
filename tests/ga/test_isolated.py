"""Learning goes on over FMUs that crash, and finds what it finds where those cost infinity."""

import sys
from dataclasses import dataclass, replace
from math import floor

import pytest

from stickslip import cosim, ga
from tests.corpus.hostile import fmus

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="the FMU is for Linux"),
]

GENES = [ga.Gene("plant.k", 0.05, 3.0, 0.8, "1")]
SETTINGS = replace(ga.DEFAULT, generations=4)


@pytest.fixture(scope="module")
def specification(tmp_path_factory):
    system = cosim.System("loop")
    system.add("plant", fmus.write(tmp_path_factory.mktemp("fragile") / "fragile.fmu"))
    system.expose("u", "plant.u")
    return cosim.Specification(system, step=0.01, stop=0.1, record=("plant.y",))


def fragile(specification):
    system = specification.system.copy()
    system.set("plant.fragile", 1.0)
    return replace(specification, system=system)


def crashes(k):
    """Return what hostile.c does: a tenth of all k, in strips."""
    return 7.0 * k - floor(7.0 * k) < 0.1


def distance(result):
    return abs(float(result["plant.y"][-1]) - 0.17)  # best at k = 1.7


@dataclass(frozen=True)
class ByFiat:
    """The cost where those that would crash are not run."""

    cost: ga.SimulatedCost

    def __call__(self, values):
        if crashes(values[0]):
            raise ga.CandidateFailed("by fiat")
        return self.cost(values)


def history(cost, workers=1):
    """Return all evaluations as text, and why some failed."""
    algorithm = ga.GeneticAlgorithm(GENES, SETTINGS)
    with ga.executor("threads", workers) as executor:
        ga.learn(algorithm, cost, executor)
    evaluations = algorithm.history
    return evaluations.drop(columns="reason").to_csv(), set(evaluations["reason"]) - {""}


@pytest.mark.parametrize("workers", [1, 2])
def test_it_ends_as_if_crashes_cost_infinity(specification, workers):
    with ga.SimulatedCost(specification, ["plant.k"], distance) as cost:
        expected, reasons = history(ByFiat(cost))
    assert reasons == {"by fiat"}
    with ga.SimulatedCost(
        fragile(specification), ["plant.k"], distance, isolation="process"
    ) as cost:
        found, reasons = history(cost, workers)
    assert found == expected
    assert reasons == {"plant (fragile.fmu): fmi2DoStep died of SIGSEGV at t = 0.06 s"}
