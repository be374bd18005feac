from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.run.guards import RealTimePacing


@pytest.fixture
def simulation(make):
    system = cosim.System("one")
    system.add("a", make("integrator"))
    system.expose("x", "a.u")
    with system.prepare(step=0.001, stop=0.1) as simulation:
        yield simulation


def test_real_time_passes_as_fast_as_asked_and_changes_no_value(simulation):
    free = simulation.run(inputs={"x": np.sin})
    assert simulation.pacing is None
    paced = simulation.run(inputs={"x": np.sin}, real_time=2.0)
    np.testing.assert_array_equal(paced.values, free.values)
    assert simulation.pacing.looks == 10
    assert simulation.pacing.clock() - simulation.pacing._start >= 0.05


@pytest.mark.parametrize(("interval", "looks"), [(0.001, 100), (0.0001, 100), (0.05, 2)])
def test_the_interval_of_looks_at_the_clock_is_chosen(simulation, interval, looks):
    pacing = RealTimePacing(10.0, interval, sleep=lambda _: None)
    for _ in range(2):
        simulation.run(real_time=pacing)
        assert simulation.pacing.looks == looks
    assert pacing.looks == 0
    with pytest.raises(cosim.ExperimentError, match="expected positive numbers"):
        RealTimePacing(1.0, 0.0)


def test_overruns_are_counted_and_the_worst_is_kept():
    now = [0.0]
    slept = []
    pacing = RealTimePacing(1.0, clock=lambda: now[0], sleep=slept.append)
    pacing.begin(5.0)
    for clock, t in ((0.005, 5.01), (0.02, 5.02), (0.05, 5.03), (0.045, 5.04)):
        now[0] = clock
        pacing.keep(t)
    assert slept == [pytest.approx(0.005)]
    assert (pacing.looks, pacing.overruns) == (4, 1)
    assert pacing.worst == pytest.approx(0.02)


def test_progress_is_told_the_time_reached(simulation):
    times = []
    simulation.run(progress=times.append)
    assert times == sorted(times)
    assert times[-1] == simulation.time[-1]
    assert len(times) == 100


def test_a_halt_lies_on_a_point_in_time_and_needs_fmus_that_serialise(simulation, tmp_path):
    with pytest.raises(cosim.ExperimentError, match="not a point in time"):
        simulation.run(until=0.0505)
    half = simulation.run(until=0.05)
    assert half.time[-1] == simulation.time[50]
    with pytest.raises(cosim.SimulationError, match=r"a cannot serialise it"):
        simulation.save(tmp_path / "a.state")
    whole = simulation.run()
    np.testing.assert_array_equal(whole.values[:51], half.values)
