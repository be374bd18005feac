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


@pytest.mark.parametrize(
    ("start", "stop", "step", "message"),
    [
        (0, float("inf"), 1, "finite"),
        (0, 1, float("nan"), "finite"),
        (0, 1, 0, "positive"),
        (1, 0, 1, "after start"),
        (0, 1e9, 1e-6, r"1e\+15 steps"),
        (-1e308, 1e308, 1e-308, "steps"),
        (1e17, 1e17 + 16, 0.1, "lost in rounding"),
        (0, 1, 0.3, "does not divide"),
    ],
)
def test_times_that_make_no_run(start, stop, step, message):
    with pytest.raises(cosim.ExperimentError, match=message):
        count_steps(start, stop, step)


def test_a_run_beyond_the_memory_is_refused():
    check_memory(1000, 1000)
    with pytest.raises(cosim.ExperimentError, match="record less"):
        check_memory(10**10, 1000)
