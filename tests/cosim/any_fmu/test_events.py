"""Events of FMI 3.0 Co-Simulation, and FMUs that end a run."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import by_fmpy, one


def last_of_each_time(result):
    keep = np.append(np.diff(result["time"]) > 1e-9, True)
    return result[keep]


@pytest.mark.parametrize("model", ["ball", "stair"])
@pytest.mark.parametrize("step", [0.01, 0.1, 0.5])
def test_event_mode_equals_fmpy(export, model, step):
    path = export(model, 3, "CS events")
    names = {"ball": ["height", "bounces"], "stair": ["count", "level"]}[model]
    system = one(path)
    ours = system.prepare(step=step, stop=3.0).run()
    how = {"step_size": step, "use_event_mode": True, "early_return_allowed": True}
    theirs = by_fmpy(path, step, 3.0, *names, **how)
    theirs = last_of_each_time(theirs)
    regular = [np.argmin(abs(theirs["time"] - t)) for t in ours.time]
    for name in names:
        np.testing.assert_allclose(ours[f"a.{name}"], theirs[name][regular], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("interfaces", ["CS", "CS events"])
def test_a_discrete_input_that_jumps_is_an_event(export, interfaces):
    system = one(export("stair", 3, interfaces), u="trigger")
    trigger = cosim.Table([0.0, 0.3, 0.7], [0, 1, 0])
    result = system.prepare(step=0.1, stop=1.0).run(inputs={"u": trigger})
    np.testing.assert_array_equal(result["a.level"], [0, 0, 0, 0, 10, 10, 10, 10, 20, 20, 20])


@pytest.mark.parametrize(
    ("version", "interfaces"), [(3, "CS events"), (2, "ME"), (3, "ME")], ids=str
)
def test_a_continuous_input_that_moves_is_no_event(export, version, interfaces):
    """Neither from outside nor from another FMU; a table that jumps between points is one."""
    path = export("oscillator", version, interfaces)
    system = one(path)
    system.add("b", path)
    system.expose("u", "a.force")
    system.connect("a.position", "b.force")
    with system.prepare(step=0.125, stop=1.0) as simulation:
        result = simulation.run(inputs={"u": np.sin(simulation.time)})
        assert not result["a.events"].any()
        assert not result["b.events"].any()
        jump = cosim.Table([0.0, 0.3], [0, 1], held=True)
        result = simulation.run(inputs={"u": jump})
        assert result["a.events"][-1] == (interfaces == "ME")
        assert not result["b.events"].any()


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize("interfaces", ["CS", "CS events"])
def test_an_fmu_that_ends_the_run_keeps_what_fmpy_keeps(export, version, interfaces):
    path = export("stair", version, interfaces)
    system = one(path, {"last": 3})
    ours = system.prepare(step=0.1, stop=2.0).run()
    how = dict.fromkeys(["use_event_mode", "early_return_allowed"], "events" in interfaces)
    theirs = by_fmpy(path, 0.1, 2.0, "count", step_size=0.1, start_values={"last": 3}, **how)
    assert ours.stopped is not None
    assert "a: " in ours.stopped
    theirs = last_of_each_time(theirs)
    if "events" not in interfaces:  # there FMPy goes on to the end of the step
        assert ours.time[-1] == pytest.approx(theirs["time"][-1])
    regular = [np.argmin(abs(theirs["time"] - t)) for t in ours.time[:8]]
    np.testing.assert_array_equal(ours["a.count"][:8], theirs["count"][regular])


@pytest.mark.parametrize("interfaces", ["CS events", "ME"])
@pytest.mark.parametrize(("start", "step"), [(1e4, 1e-5), (1.7e9, 1e-3)])
def test_time_events_are_where_they_are_after_a_late_start(export, interfaces, start, step):
    """Events two and a half steps apart: none in a row before its time, none lost."""
    period = 2.5 * step
    system = one(export("stair", 3, interfaces), {"period": period})
    result = system.prepare(start=start, step=step, stop=start + 40 * step).run()
    rows = np.arange(41)
    exact = rows / 2.5
    sure = abs(exact - np.round(exact)) > 0.01 + 41 * np.spacing(start) / period
    np.testing.assert_array_equal(result["a.count"][sure], np.floor(exact[sure]))
