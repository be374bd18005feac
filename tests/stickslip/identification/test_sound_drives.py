"""The simulator of ``campaigns.sound_drives`` against other solvers and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from campaigns.sound_drives import simulator
from campaigns.sound_drives.drives import LAWS, draw
from stickslip.servo.axis import Axis
from stickslip.servo.velocity_loop import close_velocity_loop

STAGE = {"m": 5.557, "b": 6.6135, "F_c": 5.999, "F_s": 8.999, "v_s": 5.5697e-4, "T_s": 5e-4}
BRISTLES = {"sigma_0": 3.9162e5, "sigma_1": 4424.8}
UNEVEN = {"uneven": 0.1, "period": 3e-4, "origin": 1e-4, "F_0": 0.3, "asymmetry": 0.05}
HELD = {"g_s": 40.0, "g_c": 0.5, "pitch": 2e-4, "s_1": 0.6, "c_1": -0.4, "s_2": 0.3, "c_2": 0.2}


def lugre(_, y, p, u):
    """Return the derivatives of position, velocity and bristle deflection."""
    x, v, z = y
    g = p["F_c"] + (p["F_s"] - p["F_c"]) * np.exp(-((abs(v) / p["v_s"]) ** p["delta"]))
    g *= 1.0 + p["uneven"] * np.sin(2.0 * np.pi * (x - p["origin"]) / p["period"])
    dz = v - p["sigma_0"] * abs(v) * z / (g * (1.0 + p["asymmetry"] * np.sign(v)))
    friction = p["sigma_0"] * z + p["sigma_1"] * dz
    y = 2.0 * np.pi * x / p["pitch"]
    held = p["F_0"] + p["g_s"] * np.sin(x) + p["g_c"] * np.cos(x)
    held += p["s_1"] * np.sin(y) + p["c_1"] * np.cos(y)
    held += p["s_2"] * np.sin(2.0 * y) + p["c_2"] * np.cos(2.0 * y)
    return [v, (u - held - p["b"] * v - friction) / p["m"], dz]


@pytest.mark.parametrize("delta", [1.0, 2.0])
def test_lugre_friction_is_that_of_a_stiff_solver(delta):
    p = {**STAGE, **BRISTLES, **UNEVEN, **HELD, "delta": delta}
    t = np.arange(400) * p["T_s"]
    force = 12.0 * np.sin(2.0 * np.pi * 8.0 * t)
    found = simulator.run("lugre", p, 0.0 * t, F_ff=force)
    y, expected = np.zeros(3), []
    for u in force:
        expected.append(y[1])
        y = solve_ivp(
            lugre, (0.0, p["T_s"]), y, method="Radau", args=(p, u), rtol=1e-7, atol=1e-12
        ).y[:, -1]
    assert np.ptp(expected) > 0.02
    assert found["v"] == pytest.approx(np.array(expected), abs=2e-5)


def test_coulomb_stribeck_holds_and_lets_go():
    p, n = {**STAGE, "F_s": STAGE["F_c"]}, 1000
    held = simulator.run("coulomb_stribeck", p, np.zeros(n), F_ff=np.full(n, 5.99))
    assert not held["x"].any()
    found = simulator.run("coulomb_stribeck", p, np.zeros(n), F_ff=np.full(n, 8.0))
    t = np.arange(n) * p["T_s"]
    expected = (8.0 - p["F_c"]) / p["b"] * -np.expm1(-p["b"] * t / p["m"])
    assert found["v"] == pytest.approx(expected, rel=1e-4, abs=1e-12)


@pytest.mark.parametrize("outer", [{}, {"K_x": 20.0, "velocity_feedforward": 0.8}])
def test_without_friction_the_loop_is_the_linear_one(outer):
    gains = {"K_p": 900.0, "K_i": 2.5e4, "tau_f": 8e-4, "T_s": 5e-4}
    v_cmd = np.interp(np.arange(600), [50, 150, 400, 500], [0.0, 0.05, 0.05, 0.0])
    loop = close_velocity_loop(Axis(STAGE["m"], STAGE["b"], 0.0), **gains, **outer)
    x_cmd = loop.commands(v_cmd).get("x_cmd", 0.0 * v_cmd)
    found = simulator.run("none", {**STAGE, **gains, **outer}, v_cmd, x_cmd=x_cmd)
    assert found["v"] == pytest.approx(loop.response(v_cmd)[0], abs=1e-6)


def test_drives_take_turns_and_have_their_friction():
    drives = [draw(3, number) for number in range(20)]
    assert {(one.law, one.rotary, bool(one.parameters["K_x"])) for one in drives} == {
        (law, rotary, cascade) for law in LAWS for rotary in (False, True) for cascade in (0, 1)
    }
    for one in drives[:5]:  # the motor spends F_c and viscous friction at speed
        p = {**one.parameters, "uneven": 0.0, "asymmetry": 0.0, "F_0": 0.0, "encoder": 0.0}
        v_cmd = np.full(round(1.0 / p["T_s"]), 0.5 * one.speed)
        force = simulator.run(one.law, p, v_cmd)["force"]
        assert force[-1] == pytest.approx(p["F_c"] + p["b"] * v_cmd[-1], rel=0.02)
