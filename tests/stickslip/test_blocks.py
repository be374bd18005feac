"""Blocks, functions, systems of python-control and friction laws from Python, in closed form."""

import pickle

import control
import numpy as np
import pytest

import stickslip as ss
from stickslip.errors import UsageError
from stickslip.models import LtiError

STEP, STOP = 1e-3, 0.1
M, B, K = 5.0, 20.0, 200.0
LATE = 10  # steps
STEP_UP = {"v_cmd": 1.0}


def proportional(e, gain=K):
    return gain * e


def loop() -> ss.System:
    """Return a mass with damping, its speed fed back through a function."""
    system = ss.System("loop")
    system.add("error", ss.blocks.sum("+-"))
    system.add("controller", proportional)
    system.add("plant", control.tf([1.0], [M, B], inputs="F", outputs="v"))
    system.expose("v_cmd", "error.u1")
    system.connect("error.y", "controller.e")
    system.connect("controller.y", "plant.F")
    system.connect("plant.v", "error.u2")
    return system


def test_a_loop_of_a_transfer_function_is_its_difference_equation():
    moved = pickle.loads(pickle.dumps(loop()))  # noqa: S301 - as workers do
    result = ss.simulate(moved, stop=STOP, step=STEP, inputs=STEP_UP)
    kept = np.exp(-B / M * STEP)
    pole = kept - (1.0 - kept) * K / B  # the force is held over a step
    expected = K / (B + K) * (1.0 - pole ** np.arange(len(result.time)))
    np.testing.assert_allclose(result["plant.v"], expected, rtol=1e-12)


def test_delay_gain_saturation_and_table():
    system = loop()
    system.add("late", ss.blocks.delay(LATE * STEP, STEP))
    system.add("twice", ss.blocks.gain(2.0))
    system.add("limited", ss.blocks.saturation(-0.1, 0.5))
    system.add("table", ss.blocks.lookup([0.0, 0.5, 1.0], [0.0, 1.0, 0.0]))
    system.add("clock", lambda t: 3.0 * t)
    system.expose("ramp", "late.u")
    for name in ("twice", "limited", "table"):
        system.connect("plant.v", f"{name}.u")
    ramp = ss.Table([0.0, STOP], [1.0, 2.0])
    result = ss.simulate(system, stop=STOP, step=STEP, inputs={**STEP_UP, "ramp": ramp})
    v = result["plant.v"]
    np.testing.assert_array_equal(result["late.y"], [*np.zeros(LATE), *result["ramp"][:-LATE]])
    np.testing.assert_array_equal(result["twice.y"], 2.0 * v)
    np.testing.assert_array_equal(result["limited.y"], np.minimum(v, 0.5))
    np.testing.assert_allclose(result["table.y"], 1.0 - np.abs(2.0 * v - 1.0), atol=1e-15)
    np.testing.assert_allclose(result["clock.y"], 3.0 * result.time, rtol=1e-15)


@pytest.mark.parametrize(
    ("thing", "error", "message"),
    [
        (lambda: 3, ss.cosim.ConnectionFault, "x: a int is no component; expected an FMU, its"),
        (lambda: control.tf([1.0, 0.0], [1.0]), LtiError, "improper"),
        (lambda: max, UsageError, "max: its parameters do not name the inputs; use ss.Function"),
        (lambda: lambda *u: u[0], UsageError, "its parameters do not name the inputs"),
        (lambda: ss.blocks.sum("+x"), UsageError, "signs are '[+]x'; expected one [+] or -"),
        (lambda: ss.blocks.delay(1.0, 1e-3), UsageError, "expected 1 to 300 samples"),
        (lambda: ss.blocks.delay(1.0, 0.0), UsageError, "expected 1 to 300 samples"),
        (lambda: ss.blocks.saturation(1.0, 1.0), UsageError, "expected the lower one first"),
        (lambda: ss.blocks.lookup([0.0, 0.0], [1.0, 2.0]), UsageError, "x that rises"),
        (lambda: ss.blocks.lookup([0.0, 1.0], [1.0]), UsageError, r"expected \(n,\) each"),
        (lambda: ss.blocks.lookup(["a", 1.0], [1.0]), UsageError, "points: expected numbers"),
        (lambda: ss.blocks.gain("x"), UsageError, "k: expected a number, got 'x'"),
        (lambda: ss.blocks.gain(2.0, {"in": "kN"}), UsageError, "units: there is no 'in'"),
        (lambda: ss.blocks.gain(2.0, "N"), UsageError, "units: expected a dictionary"),
        (lambda: ss.blocks.saturation(None, 1.0), UsageError, "low: expected a number, got None"),
    ],
)
def test_what_is_no_component_is_told(thing, error, message):
    with pytest.raises(error, match=message):
        ss.System("s").add("x", thing())


F_C, SIGMA_0 = 5.999, 3.9162e5  # N, N/m: start values of every law


def test_dahl_under_a_displacement_is_its_closed_form():
    result = ss.run_law("dahl", position=ss.Table([0.0, 1.0], [0.0, 2e-5]), stop=1.0, step=1e-2)
    expected = F_C * (1.0 - np.exp(-SIGMA_0 * 2e-5 * result.time / F_C))
    np.testing.assert_allclose(result["F_f"], expected, rtol=1e-12, atol=1e-12)
    same = ss.run_law("dahl", velocity=2e-5, stop=1.0, step=1e-2)
    np.testing.assert_allclose(same["dahl.F_f"], expected, rtol=1e-12, atol=1e-12)


def test_a_mass_slides_under_a_force_as_its_closed_form():
    parameters = {"F_c": 3.0, "F_s": 3.0, "m": 2.0, "b": 4.0}
    result = ss.run_law("coulomb_stribeck", force=11.0, stop=0.7, parameters=parameters)
    expected = 8.0 / 4.0 * (1.0 - np.exp(-2.0 * result.time))
    np.testing.assert_allclose(result["v"], expected, rtol=1e-6, atol=2e-8)


def test_the_stop_is_rounded_up_to_whole_steps():
    assert ss.run_law("gms", velocity=1e-3, stop=0.1005, step=1e-3).time[-1] == pytest.approx(0.101)
    assert ss.run_law("gms", velocity=1e-3, stop=0.3, step=1e-1).time[-1] == pytest.approx(0.3)


def test_one_of_motion_and_force_is_given():
    for given in ({}, {"velocity": 1e-3, "force": 1.0}):
        with pytest.raises(ss.Fault, match="expected one of velocity, position and force"):
            ss.run_law("lugre", stop=1.0, **given)
    with pytest.raises(ss.Fault, match="no friction law 'viscous'"):
        ss.run_law("viscous", velocity=1e-3, stop=1.0)
