"""Saving and resuming FMUs on the general path: events, arrays, types; Model Exchange anew."""

import numpy as np
import pytest

from stickslip import cosim
from tests.cosim.single import halves, joined, one, saves


def ends(system, path, inputs=None, parameters=None, until=1.0, **how):
    """Return the end of a whole run, and the same of one that was saved and resumed elsewhere."""
    spec = {"step": 0.1, "stop": 2.0, **how}
    whole, rest = halves(system, path, parameters, inputs, until=until, **spec)
    return whole.frame()[-len(rest.time) :], rest.frame()


@pytest.mark.parametrize("model", ["ball", "stair"])
@pytest.mark.parametrize("interfaces", ["CS", "CS events"])
def test_events(export, tmp_path, model, interfaces):
    system = one(export(model, 3, interfaces, saves(3)))
    inputs = {}
    if model == "stair":
        system.expose("u", "a.trigger")
        inputs = {"u": cosim.Table([0.0, 0.3, 1.0, 1.55], [0, 1, 0, 1])}
    whole, rest = ends(system, tmp_path / "a.state", inputs)
    np.testing.assert_array_equal(rest, whole)
    assert len(np.unique(rest, axis=0)) > 3


def test_arrays_keep_the_elements_that_are_not_fed(export, tmp_path):
    fmu = export("state_space", 3, "CS", saves(3))
    first = fmu, {"n": 2, "A": [[0.0, 1.0], [-1.0, 0.0]], "x0": [1.0, 0.0]}
    system = joined({"a": first, "b": (fmu, {"n": 2})}, "a.y b.u", x="a.u[2]")
    whole, rest = ends(system, tmp_path / "a.state", {"x": np.sin}, {"a.u[1]": 0.5})
    np.testing.assert_array_equal(rest, whole)


@pytest.mark.parametrize("model", ["ball", "stair"])
def test_the_solver_of_model_exchange_starts_anew(export, tmp_path, version, model):
    system = one(export(model, version, "ME", saves(version)))
    whole, rest = ends(system, tmp_path / "a.state", tolerance=1e-8)
    np.testing.assert_array_equal(rest.values[0], whole.values[0])
    np.testing.assert_allclose(rest, whole, rtol=1e-5, atol=1e-6)
    assert np.ptp(rest.values, axis=0).max() > 0.1


def test_a_state_by_another_interface_is_refused(export, tmp_path):
    fmu = export("oscillator", 2, "ME CS", saves(2))
    for interface in ("co_simulation", "model_exchange"):
        with one(fmu, interface=interface).prepare(step=0.1, stop=2.0) as simulation:
            if interface == "co_simulation":
                simulation.run(until=1.0)
                path = simulation.save(tmp_path / "a.state")
                continue
            message = "component a was co_simulation .* is model_exchange"
            with pytest.raises(cosim.SimulationError, match=message):
                simulation.resume(path)


JUMPS = {
    "line": cosim.Table([0.0, 0.237, 0.237, 1.0, 1.0, 2.0], [0.0, 1.0, -2.0, 1.0, 3.0, 0.0]),
    "held": cosim.Table([0.0, 0.237, 1.0], [0.5, -2.0, 3.0], held=True),
}


@pytest.mark.parametrize("table", JUMPS)
@pytest.mark.parametrize("until", [0.1, 0.2, 0.3, 0.5, 0.9, 1.0, 1.1])
@pytest.mark.parametrize("coupling", ["gauss_seidel", cosim.Coupling("jacobi", degree=1)], ids=str)
def test_jumps_of_a_table_are_not_made_again(export, tmp_path, version, table, until, coupling):
    """Model Exchange, saved before, at and after jumps on a point and between two."""
    system = one(export("oscillator", version, "ME", saves(version)), u="force")
    how = {"tolerance": 1e-9, "coupling": coupling, "until": until}
    whole, rest = ends(system, tmp_path / "a.state", {"u": JUMPS[table]}, **how)
    np.testing.assert_array_equal(rest.values[0], whole.values[0])
    np.testing.assert_allclose(rest, whole, atol=1e-6)
    np.testing.assert_array_equal(rest["a.gain"], whole["a.gain"])  # 2 force


@pytest.mark.parametrize("interfaces", ["CS events", "ME"])
@pytest.mark.parametrize("until", [0.1, 0.125, 0.2, 0.4, 0.475, 0.625, 1.0, 1.4, 1.875])
def test_ticks_of_clocks_are_not_made_again(export, tmp_path, interfaces, until):
    """Saved before, at and after ticks; 0.475 has one that asks for another at the same time."""
    system = one(export("clocked", 3, interfaces, saves(3)))
    whole, rest = ends(system, tmp_path / "a.state", until=until, step=0.025)
    np.testing.assert_array_equal(rest, whole)
    assert rest["a.every_ticks"].iloc[-1] == 8


@pytest.mark.parametrize("interfaces", ["CS events", "ME"])
def test_clocks_go_back_with_their_fmu(export, interfaces):
    """Steps that are tried again take back the ticks in them."""
    system = one(export("clocked", 3, interfaces, saves(3)))
    for name in ("b", "c"):
        system.add(name, export("oscillator", 3, "CS", saves(3)))
    system.connect("b.position", "c.force")
    coupling = cosim.Coupling("iterative", degree=2, adaptive=cosim.Adaptive(1e-7))
    with system.prepare(step=0.1, stop=2.0, coupling=coupling) as simulation:
        result = simulation.run()
        assert simulation.effort["rejected"] > 0
    clocks = one(export("clocked", 3, interfaces, saves(3))).prepare(step=0.1, stop=2.0).run()
    for name in (name for name in clocks.names if name.endswith("_ticks")):
        np.testing.assert_array_equal(result[name], clocks[name])
