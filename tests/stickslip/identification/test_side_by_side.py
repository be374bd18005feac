"""Runs of an experiment go on side by side, and what is learned does not know of it."""

import threading

import numpy as np
import pytest

from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import OutputError
from stickslip.identification.fitting.fit import linearised

pytestmark = pytest.mark.slow


@pytest.fixture(params=["inverse model", "output error"])
def criterion_of(request, recorded, candidates):
    """Return a function that makes a criterion with so many workers."""
    learned = recorded.learned.estimation
    if request.param == "inverse model":
        return lambda workers: InverseModel(candidates, learned.recording, workers=workers)
    return lambda workers: OutputError(candidates, learned.recording, learned.gains, workers)


def test_as_many_run_at_once_as_there_are_workers(criterion_of, recorded):
    values, met = recorded.learned.estimation.parameters, threading.Barrier(3)

    with criterion_of(3) as criterion:
        residual = criterion.residual

        def run(values):
            met.wait(timeout=60.0)  # broken if no two others come
            return residual(values)

        criterion.residual = run
        first, *others = criterion.map([values] * 3)
        assert all(np.array_equal(first, other) for other in others)


def test_a_slope_has_the_same_bits(criterion_of, recorded):
    best = recorded.learned.estimation.fit
    with criterion_of(1) as alone, criterion_of(3) as together:
        one, other = (
            linearised(criterion.over(best.space), best.q, 1.0) for criterion in (alone, together)
        )
    np.testing.assert_array_equal(one.jacobian, other.jacobian)
    np.testing.assert_array_equal(one.residual, other.residual)
