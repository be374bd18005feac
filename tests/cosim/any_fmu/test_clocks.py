"""Input clocks of FMI 3.0 tick when their intervals have passed. FMPy leaves them to the caller."""

from __future__ import annotations

import logging

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import one

STEP, STOP = 0.1, 2.0


@pytest.fixture(params=["CS events", "ME"])
def interfaces(request):
    return request.param


def run(path, step=STEP):
    system = one(path)
    with system.prepare(step=step, stop=STOP) as simulation:
        first = simulation.run()
        np.testing.assert_array_equal(simulation.run().values, first.values)
    return first


@pytest.mark.parametrize("step", [0.1, 0.5, 0.0625])
@pytest.mark.parametrize(
    ("clock", "ticks"),
    [
        ("every", 0.125 + 0.25 * np.arange(8)),
        ("growing", [0.0, 0.2, 0.6, 1.4]),  # 0.1 before the first tick, then 0.2, 0.4, 0.8
        ("after", [0.475, 0.475]),
        ("by_hand", []),
        ("asked", [0.0, 0.4, 0.8, 1.2, 1.6, 2.0]),
    ],
)
def test_a_clock_ticks_at_its_times(export, interfaces, step, clock, ticks):
    result = run(export("clocked", 3, interfaces), step)
    reached = np.searchsorted(ticks, result.time + 1e-9)
    np.testing.assert_array_equal(result[f"a.{clock}_ticks"], reached)
    last = np.concatenate([[0.0], ticks])[reached]
    np.testing.assert_allclose(result[f"a.{clock}_at"], last, atol=1e-12)


def test_clocks_that_will_not_tick_are_named(export, caplog):
    with caplog.at_level(logging.WARNING, "stickslip.cosim.fmu.fmu"):
        cosim.Fmu(export("clocked", 3, "CS events"))
        assert "the clocks by_hand never tick: only clocks with an interval do" in caplog.text
        caplog.clear()
        fmu = cosim.Fmu(export("clocked", 3, "CS"))
    assert "the clocks every, growing, after, by_hand, asked never tick" in caplog.text
    assert fmu.clocks == []


@pytest.mark.parametrize("start", [1e4, 1.7e9])
def test_a_clock_ticks_at_its_times_after_a_late_start(export, interfaces, start):
    """The intervals of these clocks are those of the run from 0 on, in steps of 0.025 s."""
    system = one(export("clocked", 3, interfaces))
    late = system.prepare(step=0.025, start=start, stop=start + STOP).run()
    soon = system.prepare(step=0.025, stop=STOP).run()
    for name in (name for name in soon.names if name.endswith("_ticks")):
        np.testing.assert_array_equal(late[name], soon[name])
