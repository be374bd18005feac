"""Runs of an experiment go on side by side, and what is learned does not know of it."""

import threading

import numpy as np
import pytest

from stickslip.identification.criteria import runs
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import OutputError
from stickslip.identification.criteria.runs import Runs
from stickslip.identification.fitting.fit import linearised
from stickslip.servo.lanes import FEWEST

pytestmark = pytest.mark.slow


@pytest.fixture(params=["inverse model", "output error"])
def criterion_of(request, recorded, candidates):
    """Return a function that makes a criterion with so many workers."""
    learned = recorded.learned.estimation
    if request.param == "inverse model":
        return lambda workers: InverseModel(candidates, learned.recording, workers=workers)
    return lambda workers: OutputError(candidates, learned.recording, learned.gains, workers)


def test_as_many_run_at_once_as_there_are_workers(criterion_of, recorded, monkeypatch):
    values, met, run = recorded.learned.estimation.parameters, threading.Barrier(3), Runs.run

    def together(*arguments, **others):
        met.wait(timeout=60.0)  # broken if no two others come
        return run(*arguments, **others)

    monkeypatch.setattr(Runs, "run", together)
    points = [{**values, "F_c": k * values["F_c"]} for k in (0.9, 1.0, 1.1)]
    assert len(points) < FEWEST
    with criterion_of(3) as criterion:
        criterion.map(points)


def test_what_runs_side_by_side_may_run_once_more(criterion_of, recorded):
    """A thread that waited for another one of the same few would wait for ever."""
    values = recorded.learned.estimation.parameters
    points = [{**values, "F_c": k * values["F_c"]} for k in (0.9, 1.0, 1.1)]
    with criterion_of(2) as criterion:
        runs = criterion.loop._logs[0].runs if hasattr(criterion, "loop") else criterion.runs
        found = runs.each(criterion.residual, points)
    assert len({one.tobytes() for one in found}) == len(points)


def test_a_slope_has_the_same_bits(criterion_of, recorded, monkeypatch):
    """Whatever the number of workers, and in lanes as by the FMUs."""
    best, found = recorded.learned.estimation.fit, []
    for workers, in_lanes in ((1, True), (3, True), (3, False)):
        if not in_lanes:
            monkeypatch.setattr(runs, "lanes_of", lambda _: None)
        with criterion_of(workers) as criterion:
            found.append(linearised(criterion.over(best.space), best.q, 1.0))
    for other in found[1:]:
        np.testing.assert_array_equal(other.jacobian, found[0].jacobian)
        np.testing.assert_array_equal(other.residual, found[0].residual)
