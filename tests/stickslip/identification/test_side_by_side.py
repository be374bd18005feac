"""Runs of an experiment go on side by side, and what is learned does not know of it."""

import threading

import numpy as np
import pytest

from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.criteria.known_loop import OutputError
from stickslip.identification.fitting.fit import linearised

pytestmark = pytest.mark.slow


def test_as_many_run_at_once_as_there_are_workers(recorded, candidates):
    learned, met = recorded.learned.estimation, threading.Barrier(3)

    with InverseModel(candidates, learned.recording, workers=3) as criterion:
        residual = criterion.residual

        def run(values):
            met.wait(timeout=60.0)  # broken if no two others come
            return residual(values)

        criterion.residual = run
        first, *others = criterion.map([learned.parameters] * 3)
        assert all(np.array_equal(first, other) for other in others)


def test_a_slope_has_the_same_bits(recorded, candidates):
    learned, found = recorded.learned.estimation, []
    for workers in (1, 3):
        with OutputError(candidates, learned.recording, learned.gains, workers) as criterion:
            found.append(linearised(criterion.over(learned.fit.space), learned.fit.q, 1.0))
    np.testing.assert_array_equal(found[0].jacobian, found[1].jacobian)
    np.testing.assert_array_equal(found[0].residual, found[1].residual)
