"""Model Exchange of laws with modes: state events against closed forms and two solvers."""

import itertools
from ctypes import POINTER, c_double

import numpy as np
import pytest

from stickslip import cosim
from tests.conformance.test_model_exchange import SWITCHED
from tests.cosim import single

FORCES = [9.5, -9.5, 3.0]  # N, each held for PIECE: away, through a reversal, to a stop
PIECE = 0.02  # s
LAWS = pytest.mark.parametrize("law", SWITCHED)
F_S = 8.999  # N


def held(times, forces):
    """Return a table of forces that jump at the times."""
    pairs = itertools.pairwise(times)
    return np.array([(t, u) for ends, u in zip(pairs, forces, strict=True) for t in ends])


def mode_names(fmu):
    names = [v.name for v in fmu.model.variables]
    return [n for n in names if n.partition("[")[0] in ("mode", "slip")]


def by_fmpy(fmu, table, step, *outputs, **options):
    """Let FMPy's CVode integrate under forces in a straight line between the table's rows."""
    how = {"fmi_type": "ModelExchange", "relative_tolerance": 1e-9, "record_events": False}
    time, u = table.T
    return single.by_fmpy(
        fmu.path, step, time[-1], *outputs, inputs=[time, ("u", "f8", u)], **how | options
    )


def by_master(fmu, table, step, interface="model_exchange", tolerance=1e-9, **start):
    system = single.one(fmu.path, start, "u", interface=interface)
    names = [f"a.{n}" for n in ("x", "v", "F_f", *mode_names(fmu))]
    options = {"step": step, "stop": table[-1, 0], "tolerance": tolerance, "record": names}
    return system.prepare(**options).run(inputs={"u": cosim.Table(*table.T)})


@LAWS
def test_the_motion_and_the_modes_are_those_of_another_solver_and_of_co_simulation(
    build, law, version
):
    """Through slip, reversal and stop; tests/models compares Co-Simulation with other programs."""
    fmu = build(f"stage+{law}", version)
    times = PIECE * np.arange(len(FORCES) + 1)
    theirs = by_fmpy(fmu, held(times, FORCES), PIECE, "x", "v", *mode_names(fmu))
    ours = by_master(fmu, held(times, FORCES), PIECE)
    step = 2e-6
    forces = np.append(np.repeat(FORCES, round(PIECE / step)), FORCES[-1])
    table = np.transpose([step * np.arange(len(forces)), forces])
    stepped = by_master(fmu, table, step, interface="co_simulation")
    at = np.round(times / step).astype(int)
    assert np.abs(ours["a.v"]).max() > 5e-3
    for name, stepped_within in (("x", 1e-8), ("v", 5e-7)):
        found = ours[f"a.{name}"]
        np.testing.assert_allclose(found, theirs[name], atol=1e-8)
        np.testing.assert_allclose(found, stepped[f"a.{name}"][at], atol=stepped_within)
    for name in mode_names(fmu):
        np.testing.assert_array_equal(ours[f"a.{name}"], theirs[name])
        np.testing.assert_array_equal(ours[f"a.{name}"][1:], stepped[f"a.{name}"][at[1:]])


def test_on_a_ramp_the_mass_breaks_away_and_sticks_again_in_closed_form(build, version):
    """With F_s = F_c = F and b = 0 the force in excess is a straight line up and down.

    Up to F + P at rate r and down again: the mass moves from F / r on, and stops a time
    (1 + sqrt 2) P / r after the peak, (P^3 / r^2 / m) (1 + 2 sqrt 2 / 3) away.
    """
    fmu = build("stage+coulomb_stribeck", version)
    r, F, P, m = 20.0, 6.0, 2.0, 4.0
    start = {"F_s": F, "F_c": F, "b": 0.0, "m": m}
    peak = (F + P) / r
    table = np.array([(0.0, 0.0), (peak, F + P), (peak + 6.0 / r, F + P - 6.0)])
    found = by_master(fmu, table, 1e-4, **start)
    moving = found.time[found["a.v"] != 0.0]
    stop = peak + (1.0 + np.sqrt(2.0)) * P / r
    assert F / r < moving[0] <= F / r + 1.01e-4
    assert stop - 1.01e-4 <= moving[-1] < stop
    distance = P**3 / r**2 / m * (1.0 + 2.0 * np.sqrt(2.0) / 3.0)
    assert found["a.x"][-1] == pytest.approx(distance, rel=1e-7)
    rest = found.time > stop
    assert len(set(found["a.x"][rest])) == 1
    np.testing.assert_allclose(found["a.F_f"][rest], np.interp(found.time, *table.T)[rest])
    loose = {"relative_tolerance": 1e-4}  # FMPy holds the input between its calls for indicators
    events = by_fmpy(fmu, table, 0.1, "v", record_events=True, start_values=start, **loose)["time"]
    assert np.abs(events - F / r).min() < 1e-12


@pytest.mark.parametrize("excess", [0.0, 1e-3])
def test_a_force_that_just_touches_static_friction(build, excess):
    """At F_s it moves nothing; a peak 1e-3 N higher is found, and moves 0.1 nm."""
    fmu = build("stage+coulomb_stribeck", 3)
    peak = F_S + excess
    table = np.array([(0.0, peak - 1.0), (1.0, peak), (2.0, peak - 1.0)])
    start = {"F_c": F_S, "b": 0.0, "m": 4.0}
    found = by_master(fmu, table, 0.125, tolerance=1e-10, **start)
    distance = excess**3 / 4.0 * (1.0 + np.sqrt(2.0) * 2.0 / 3.0)
    assert found["a.x"][-1] == pytest.approx(distance, rel=1e-3, abs=0.0)
    assert not found["a.v"][-1]
    assert not found["a.x"][:8].any()


def test_errors_of_a_solver_are_no_events_without_end(build):
    """A tolerance of ten Stribeck velocities: steps end at velocities of the wrong sign."""
    fmu = build("stage+coulomb_stribeck", 2)
    forces = 12.0 * np.sin(np.arange(40.0) ** 2)
    table = held(0.05 * np.arange(41), forces)
    loose, exact = (
        by_master(fmu, table, 0.05, tolerance=tolerance, v_s=1e-6) for tolerance in (1e-3, 1e-9)
    )
    largest = np.abs(exact["a.x"]).max()
    np.testing.assert_allclose(loose["a.x"] / largest, exact["a.x"] / largest, atol=0.1)


@pytest.mark.parametrize("law", ["coulomb_stribeck", "gms"])
def test_a_stuck_mass_does_not_creep(build, law):
    """100 s under 60 % of F_c after a motion that ended there, with an oscillation of 10 %."""
    fmu = build(f"stage+{law}", 2)
    time = np.linspace(0.5, 100.5, 2001)
    load = 3.6 + 0.6 * np.sin(2 * np.pi * (time - 0.5))
    table = np.array([(0.0, 9.5), (0.1, 9.5), *zip(time, load, strict=True)])
    x = by_master(fmu, table, 0.25, tolerance=1e-8)["a.x"]
    assert x[-1] > 1e-4
    assert np.ptp(x[10:-360:4]) <= (0.0 if law == "coulomb_stribeck" else 1e-10)
    np.testing.assert_allclose(x[50:-4:4], x[-1], atol=0.0 if law == "coulomb_stribeck" else 1e-9)


@LAWS
def test_events_end_in_modes_that_hold(build, exchanged, law, version):
    """From any point: nothing is left to do, what slips is bent forward, and jumps are reported."""
    fmu, seen = build(f"stage+{law}", version), set()
    instance = exchanged(fmu)
    for n, point in enumerate(fmu.points(100)):
        point |= {"v": 0.0} if n % 4 == 3 else {}
        instance.api.reset()
        reported = instance.initialize(point).updated()
        states, modes = instance.vector("ContinuousStates"), instance.get(mode_names(fmu))
        asked = [point[name] for name in fmu.names("state")[: instance.n_states]]
        assert reported["states"] == (states != asked).any()
        assert not any(reported[flag] for flag in ("again", "ends", "nominals", "timed"))
        assert (indicators(instance) > 0.0).all()
        assert all(mode * bent > 0.0 for mode, bent in zip(modes, states[2:], strict=False) if mode)
        assert not instance.updated()["states"]
        assert instance.get(mode_names(fmu)) == modes
        seen.add(tuple(modes))
    assert len(seen) > 2


def indicators(instance):
    values = np.empty(len(instance.fmu.names("indicator")))
    instance.api.getEventIndicators(values.ctypes.data_as(POINTER(c_double)), len(values))
    return values


def test_modes_change_in_event_mode_only_and_a_restored_state_changes_them_again(
    build, exchanged, identical, version
):
    """The velocity has crossed 0 under a force that static friction holds."""
    fmu = build("stage+coulomb_stribeck", version)
    instance = exchanged(fmu).initialize({"v": 1e-3})
    assert instance.updated()["states"] == 0
    instance.api.enterContinuousTimeMode()
    for v in (1e-3, 1e-12, -1e-12, -1e-3):
        instance.place(0.1, [0.0, v])
        assert instance.get(["mode"]) == [1.0]
        assert (indicators(instance)[0] > 0.0) == (v > 0.0)
    instance.place(0.1, [0.0, -1e-12])
    instance.api.enterEventMode()
    state = instance.api.getFMUState()
    bits = instance.api.serializeFMUState(state)
    crossed = instance.everything()
    for _ in range(2):
        assert instance.updated()["states"] == 1
        assert instance.get(["mode", "v"]) == [0.0, 0.0]
        assert instance.updated()["states"] == 0
        instance.api.enterContinuousTimeMode()
        assert indicators(instance)[0] > 0.0
        instance.api.setFMUState(state)
        assert identical(instance.everything(), crossed)
    instance.api.setFMUState(instance.api.deserializeFMUState(bits))
    assert instance.updated()["states"] == 1
    instance.set({"u": 9.5})
    assert instance.updated()["states"] == 0  # it breaks away, and no state jumps
    assert instance.get(["mode", "v"]) == [1.0, 0.0]


def test_a_parameter_changed_at_an_event_changes_the_modes(build, exchanged):
    instance = exchanged(build("stage+coulomb_stribeck", 3)).initialize({"u": 8.0})
    instance.updated()
    assert instance.get(["mode", "F_f"]) == [0.0, 8.0]
    instance.set({"F_s": 7.0})
    instance.updated()
    assert instance.get(["mode", "F_f"]) == [1.0, 7.0]


def test_a_law_without_such_equations_is_refused_in_one_line(build):
    fmu = build("stage+armstrong", 2)
    system = cosim.System()
    with pytest.raises(cosim.FmuError, match="no interface 'model_exchange'; it has co_simulation"):
        system.add("a", fmu.path, interface="model_exchange")
    assert fmu.description.modelExchange is None
    assert "Co-Simulation only" in fmu.description.description
