"""Integers, Booleans and events in a container: the values of the system, in FMPy."""

import numpy as np
import pytest

from stickslip import cosim
from stickslip.fmi import toolchain
from tests.cosim.single import by_fmpy, one

STEP, STOP = 0.05, 2.0


def test_a_container_gives_the_values_of_the_system(export, tmp_path):
    system = one(export("stair", 3, "CS events"), {"period": 0.13}, u="trigger")
    system.add("b", export("feedthrough", 3, "CS events"))
    system.connect("a.count", "b.Int32_in")
    system.connect("a.level", "b.Float64_in")
    system.expose("on", "b.Boolean_in")
    with system.prepare(step=STEP, stop=STOP) as simulation:
        time = simulation.time
        u, on = np.floor(time / 0.35) % 2 > 0, time > 1.0
        ours = simulation.run(inputs={"u": u, "on": on})
    path = cosim.write_fmu(system, tmp_path / "a.fmu", step=STEP, fmi=2)
    names = ["a.count", "a.level", "b.Int32_out", "b.Boolean_out", "b.Float64_out"]
    theirs = by_fmpy(path, STEP, STOP, *names, inputs=[time, ("u", "?", u), ("on", "?", on)])
    for name in names:
        assert len(np.unique(ours[name])) > 1
        np.testing.assert_array_equal(theirs[name], ours[name])
    assert theirs["b.Boolean_out"].dtype == np.bool_
    assert theirs["b.Int32_out"].dtype == np.int32


def test_model_exchange_in_a_container(export, tmp_path):
    """Two oscillators and a stair, with time and state events, by the solver in the resources."""
    system = one(export("oscillator", 2, "ME"), {"position": 0.5}, "force")
    system.add("b", export("oscillator", 2, "ME"), {"position": 0.0})
    system.add("c", export("stair", 2, "ME"), {"period": 0.13})
    system.add("d", export("ball", 2, "ME"))
    system.connect("c.count", "b.force")
    ours = system.prepare(step=STEP, stop=STOP).run(inputs={"u": 0.25})
    path = cosim.write_fmu(system, tmp_path / "a.fmu", step=STEP, fmi=3)
    names = ["a.position", "b.position", "c.count", "d.bounces", "d.height"]
    theirs = by_fmpy(path, STEP, STOP, *names, start_values={"u": 0.25})
    for name in names:
        assert len(np.unique(ours[name])) > 1
        np.testing.assert_array_equal(theirs[name], ours[name])


def test_an_input_of_a_container_holds_for_the_step(export, tmp_path):
    """An oscillator at rest under a force that steps: x = F/k (1 - cos 2 (t - t0))."""
    system = one(export("oscillator", 3, "ME"), {"position": 0.0}, "force")
    path = cosim.write_fmu(system, tmp_path / "a.fmu", step=STEP)
    time = np.arange(0.0, STOP + STEP / 2, STEP)
    late = time > 1.0
    theirs = by_fmpy(path, STEP, STOP, "a.position", inputs=[time, ("u", "f8", 4.0 * late)])
    began = time[late][0]
    exact = np.where(late, 1 - np.cos(2 * (time - began)), 0.0)
    np.testing.assert_allclose(theirs["a.position"], exact, atol=2e-4)


def test_a_platform_without_the_solver_is_refused(export, tmp_path):
    system = one(export("stair", 2, "ME"))
    target = toolchain.PLATFORMS["aarch64-linux"]
    with pytest.raises(cosim.FmuError, match="not for aarch64-linux; use Co-Simulation, or leave"):
        cosim.write_fmu(system, tmp_path / "a.fmu", step=STEP, platforms=[target])


def test_what_a_container_does_not_run(export, tmp_path):
    wide = one(export("feedthrough", 3, "CS"), u="Int64_in")
    with pytest.raises(cosim.ConnectionFault, match="input u is a Int64, which a container does"):
        cosim.write_fmu(wide, tmp_path / "a.fmu", step=STEP)
