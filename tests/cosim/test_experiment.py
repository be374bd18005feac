"""Times that make no run, or one that no machine has room for, are refused before it begins."""

from __future__ import annotations

import pytest

from stickslip import cosim
from stickslip.cosim.assembly.plan import check_memory, count_steps


@pytest.mark.parametrize(
    ("start", "stop", "step", "n"),
    [(0, 1, 0.1, 10), (-1, 1, 0.001, 2000), (1.7e9, 1.7e9 + 1, 1e-3, 1000), (0, 1e10, 1, 10**10)],
)
def test_steps_are_counted(start, stop, step, n):
    assert count_steps(start, stop, step) == n


def test_a_run_beyond_the_memory_is_refused():
    check_memory(1000, 1000)
    with pytest.raises(cosim.ExperimentError, match="record less"):
        check_memory(10**10, 1000)
