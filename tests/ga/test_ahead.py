"""A generation is known before the costs of the one before, so that no worker has to wait."""

import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from problems import GENES, quadratic

from stickslip import ga
from stickslip.ga.execution.evaluation import Evaluator

NOISY = replace(ga.PRESETS["default"], noisy=True)


def optimiser(settings=ga.PRESETS["default"], **limits):
    return ga.GeneticAlgorithm(GENES, settings, limits=ga.Limits(**limits))


@pytest.mark.parametrize("settings", [ga.PRESETS["default"], NOISY], ids=["plain", "noisy"])
def test_what_is_foreseen_is_asked(settings):
    algorithm = optimiser(settings, generations=30)
    children = settings.population - settings.elites
    foreseen = algorithm.ahead
    for generation in range(12):
        asked = algorithm.ask()
        np.testing.assert_array_equal(asked[: len(foreseen)], foreseen)
        foreseen = algorithm.ahead
        assert len(foreseen) == (children if generation else 0)
        algorithm.tell([quadratic(values) for values in asked])


def test_a_fresh_start_forgets_what_was_foreseen():
    settings = replace(ga.PRESETS["default"], patience=1)
    algorithm = optimiser(settings, generations=30)
    anew = 0
    for _ in range(12):
        asked, foreseen = algorithm.ask(), algorithm.ahead
        algorithm.tell([1.0] * len(asked))
        if len(foreseen) and algorithm.batch == settings.population:
            anew += 1
            assert not np.array_equal(algorithm.ask()[: len(foreseen)], foreseen)
            algorithm.tell([1.0] * settings.population)
    assert anew > 1


@pytest.mark.parametrize("kind", ["paper", "cma", "de"])
def test_other_methods_know_nothing_beforehand(kind):
    algorithm = ga.optimiser(kind, ga.Problem(GENES), ga.Limits(generations=9))
    for _ in range(3):
        algorithm.tell([quadratic(values) for values in algorithm.ask()])
        algorithm.ask()
        assert algorithm.ahead.shape == (0, len(GENES))
        algorithm.tell([1.0] * algorithm.batch)


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
    assert len(evaluated) == algorithm.evaluations


def test_what_was_begun_in_vain_is_called_off():
    release = threading.Event()

    def cost(values):
        assert values[0] < 2 or release.wait(timeout=30)
        return float(values[0])

    rows = np.arange(1.0, 6.0).reshape(5, 1)
    with ThreadPoolExecutor(1) as threads:
        evaluator = Evaluator(cost, threads)
        assert evaluator.outcomes(rows[:1], rows[1:], begins=False) == [(1.0, "")]
        begun = [place.task.future for place in evaluator._begun.values()]
        evaluator.dismiss()
        assert all(future.cancelled() for future in begun[1:])  # the first may be under way
        release.set()


def test_a_run_that_ends_early_leaves_nothing_in_the_queue():
    evaluated = []

    def cost(values):
        evaluated.append(1)
        if len(evaluated) < 30:
            return quadratic(values)
        time.sleep(0.1)  # the run ends meanwhile
        return 0.0

    with ThreadPoolExecutor(1) as threads:
        algorithm = optimiser(generations=50, target=0.0)
        ga.learn(algorithm, cost, threads)
    assert len(evaluated) <= algorithm.evaluations + 2  # of eight; one may have been under way
