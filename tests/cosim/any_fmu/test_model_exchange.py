"""Model Exchange: closed-form solutions, FMPy's CVode, and the times of events."""

import math
import sys
from functools import partial

import numpy as np
import pytest

from stickslip import cosim
from stickslip.cosim.assembly import general_path
from tests.cosim import single

G = 9.81
FINE = 1e-8


one = partial(single.one, interface="model_exchange")


def fmpy_run(path, step, stop, *output, **more):
    how = {"fmi_type": "ModelExchange", "relative_tolerance": FINE, "record_events": False, **more}
    return single.by_fmpy(path, step, stop, *output, **how)


def test_an_oscillator_follows_the_cosine_and_fmpy_to_the_bit(export, version):
    path = export("oscillator", version, "ME")
    result = one(path).prepare(step=0.05, stop=20.0, tolerance=FINE).run()
    np.testing.assert_allclose(result["a.position"], np.cos(2 * result.time), atol=2e-6)
    np.testing.assert_allclose(result["a.velocity"], -2 * np.sin(2 * result.time), atol=4e-6)
    theirs = fmpy_run(path, 0.05, 20.0, "position")
    np.testing.assert_array_equal(result["a.position"], theirs["position"])


def test_a_bouncing_ball_bounces_when_the_parabola_ends(export, version):
    e, first = 0.7, math.sqrt(2 / G)
    bounces = first * (1 + 2 * np.cumsum([0.0, *(e**i for i in range(1, 8))]))
    path = export("ball", version, "ME")
    result = one(path).prepare(step=1e-3, stop=2.3, tolerance=FINE).run()
    theirs = fmpy_run(path, 1e-3, 2.3, "height")["height"]
    np.testing.assert_array_equal(result["a.height"], theirs)
    seen = result.time[1:][np.diff(result["a.bounces"]) > 0]
    np.testing.assert_allclose(seen, np.ceil(bounces[bounces < 2.3] / 1e-3) * 1e-3, atol=1e-9)
    falling = result.time < first
    expected = 1 - G / 2 * result.time[falling] ** 2
    np.testing.assert_allclose(result["a.height"][falling], expected, atol=1e-7)


def test_inputs_move_within_the_step_as_in_fmpy(export, version):
    path = export("oscillator", version, "ME")
    system = one(path, u="force")
    time = np.linspace(0, 10, 1001)
    force = np.sin(3 * time)
    ours = system.prepare(step=0.01, stop=10.0).run(inputs={"u": cosim.Table(time, force)})
    signals = [time, ("force", "f8", force)]
    theirs = fmpy_run(path, 0.01, 10.0, "position", "gain", inputs=signals)
    exact = np.cos(2 * time) + (np.sin(2 * time) * 1.5 - np.sin(3 * time)) / 5
    np.testing.assert_allclose(ours["a.position"], exact, atol=3e-4)
    np.testing.assert_allclose(ours["a.gain"], theirs["gain"], atol=1e-12)
    error, of_fmpy = (abs(x - exact).max() for x in (ours["a.position"], theirs["position"]))
    assert error < max(of_fmpy, 3e-4)


@pytest.mark.parametrize("degree", [0, 1])
def test_an_input_holds_over_each_of_the_steps(export, version, degree):
    system = one(export("oscillator", version, "ME"), u="force")
    force = np.repeat(np.sin(np.arange(11)), 4)[:41]
    how = {"step": 0.05, "stop": 2.0, "coupling": cosim.Coupling(degree=degree)}
    with system.prepare(**how) as simulation:
        held = cosim.Table(simulation.time, force, held=True)
        whole = simulation.run(inputs={"u": held})["a.position"]
        found = [simulation.start(inputs={"u": force[0]})["a.position"]]
        found += [simulation.step({"u": u})["a.position"] for u in force[:-1]]
    np.testing.assert_array_equal(found, whole)
    with system.prepare(**how) as simulation:  # the first step may begin with a jump
        simulation.start(inputs={"u": -1.0})
        found = [simulation.step({"u": u})["a.position"] for u in force[:-1]]
    np.testing.assert_allclose(found, whole[1:], atol=1e-12)


def test_without_its_solver_one_line_says_where_there_is_one(export, version, monkeypatch):
    general_path._cvode_table.cache_clear()
    monkeypatch.setitem(sys.modules, "fmpy.sundials", None)  # as on aarch64-linux
    with pytest.raises(
        cosim.FmuError, match=r"needs the solver CVode.*its Co-Simulation interface"
    ):
        one(export("oscillator", version)).prepare(step=0.1, stop=1.0)
