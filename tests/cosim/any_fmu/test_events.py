"""Events and clocks of FMI 3.0, and FMUs that end a run."""

import logging

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import by_fmpy, joined, one


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
    system = joined(dict.fromkeys("ab", path), "a.position b.force", u="a.force")
    with system.prepare(step=0.125, stop=1.0) as simulation:
        result = simulation.run(inputs={"u": np.sin(simulation.time)})
        assert not result["a.events"].any()
        assert not result["b.events"].any()
        jump = cosim.Table([0.0, 0.3], [0, 1], held=True)
        result = simulation.run(inputs={"u": jump})
        assert result["a.events"][-1] == (interfaces == "ME")
        assert not result["b.events"].any()


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


STEP, STOP = 0.1, 2.0


@pytest.fixture(params=["CS events", "ME"])
def interfaces(request):
    return request.param


def run(system, step):
    """Return the result of a run, which the next one repeats."""
    with system.prepare(step=step, stop=STOP) as simulation:
        first = simulation.run()
        np.testing.assert_array_equal(simulation.run().values, first.values)
    return first


TICKS = {
    "every": 0.125 + 0.25 * np.arange(8),
    "growing": [0.0, 0.2, 0.6, 1.4],  # 0.1 before the first tick, then 0.2, 0.4, 0.8
    "after": [0.475, 0.475],
    "by_hand": [],
    "asked": [0.0, 0.4, 0.8, 1.2, 1.6, 2.0],
}


@pytest.mark.parametrize("step", [0.1, 0.5, 0.0625])
def test_a_clock_ticks_at_its_times(export, interfaces, step):
    result = run(one(export("clocked", 3, interfaces)), step)
    for clock, ticks in TICKS.items():
        reached = np.searchsorted(ticks, result.time + 1e-9)
        np.testing.assert_array_equal(result[f"a.{clock}_ticks"], reached, err_msg=clock)
        last = np.concatenate([[0.0], ticks])[reached]
        np.testing.assert_allclose(result[f"a.{clock}_at"], last, atol=1e-12, err_msg=clock)


def test_clocks_that_will_not_tick_are_named(export, caplog):
    with caplog.at_level(logging.WARNING, "stickslip.cosim.fmu.fmu"):
        fmu = cosim.Fmu(export("clocked", 3, "CS"))
    assert "the clocks every, growing, after, by_hand, asked never tick" in caplog.text
    assert fmu.clocks == []
    system = one(export("clocked", 3, "CS"))
    assert "a.tock" not in system.prepare(step=STEP, stop=STOP).run().names
    with pytest.raises(cosim.ConnectionFault, match="by_hand is a Clock input, expected"):
        system.expose("tick", "a.by_hand")


@pytest.mark.parametrize("step", [0.125, 0.1])
def test_an_output_clock_ticks_the_input_clock_that_it_is_connected_to(export, interfaces, step):
    """Its column is 1 after each step in which it ticked; each tick is one event of the other."""
    parts = dict.fromkeys("ab", export("clocked", 3, interfaces))
    result = run(joined(parts, "a.tock b.by_hand"), step)
    every = np.diff(result["a.every_ticks"], prepend=0)
    np.testing.assert_array_equal(result["a.tock"], every)
    np.testing.assert_array_equal(result["b.by_hand_ticks"], result["a.every_ticks"])


def test_clocks_are_connected_in_ssp_2(export, tmp_path):
    system = joined(dict.fromkeys("ab", export("clocked", 3, "CS events")))
    cosim.write_ssp(system, tmp_path / "apart.ssp")
    system.connect("a.tock", "b.by_hand")
    with pytest.raises(cosim.SspError, match=r"a\.tock is a clock, which SSP 1.0 has not"):
        cosim.write_ssp(system, tmp_path / "one.ssp")
    cosim.write_ssp(system, tmp_path / "two.ssp", version="2.0")
    assert cosim.read_ssp(tmp_path / "two.ssp")[0].connections == system.connections


def test_a_triggered_clock_ticks_where_its_input_is_not_0(export, interfaces):
    system = one(export("clocked", 3, interfaces), u="by_hand")
    table = cosim.Table([0.0, 0.15, 0.6, 0.85], [1.0, 0.0, 1.0, 0.0], held=True)
    result = system.prepare(step=0.1, stop=STOP).run(inputs={"u": table})
    ticks = np.array([0.0, 0.1, 0.6, 0.7, 0.8])
    late = 0 if interfaces == "ME" else 1e-9  # Co-Simulation takes inputs when its next step begins
    reached = np.searchsorted(ticks + late, result.time + 1e-12, side="right")
    np.testing.assert_array_equal(result["a.by_hand_ticks"], reached)


@pytest.mark.parametrize("start", [1e4, 1.7e9])
def test_a_clock_ticks_at_its_times_after_a_late_start(export, interfaces, start):
    """The intervals of these clocks are those of the run from 0 on, in steps of 0.025 s."""
    system = one(export("clocked", 3, interfaces))
    late = system.prepare(step=0.025, start=start, stop=start + STOP).run()
    soon = system.prepare(step=0.025, stop=STOP).run()
    for name in (name for name in soon.names if name.endswith("_ticks")):
        np.testing.assert_array_equal(late[name], soon[name])
