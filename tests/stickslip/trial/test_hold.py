"""Hunting of a cascade at rest, against a simulation by other equations of motion."""

import numpy as np
import pytest

from campaigns.sound_drives import simulator
from stickslip.catalog.parameters import friction_law
from stickslip.servo.axis import Axis, Datasheet
from stickslip.servo.velocity_loop import close_velocity_loop
from stickslip.trial.benefit import NONE, Bench, feedforward
from stickslip.trial.family import Command, Drive
from stickslip.trial.hold import _commands, hold_time, holds, hunting_at_rest, reversals
from tests.kept import further

LAW = friction_law("coulomb_stribeck")
FRICTION = {"F_s": 9.0, "F_c": 6.0, "v_s": 1e-4, "delta": 1.0}
AXIS = Axis(5.557, 6.6135)
STEP, T_S = 4e-7, 5e-4


def cascade(K_i=4e5, K_x=75.0):
    return close_velocity_loop(AXIS, T_S, T_S, 4717.0, K_i, K_x=K_x)


@pytest.fixture(scope="module")
def held(tmp_path_factory):
    """Return how a cascade holds its position, without a compensator and with one."""
    folder = tmp_path_factory.mktemp("bench")

    def held(loop, **changes):
        drive = Drive("friction as fitted", LAW.name, {**FRICTION, **changes})
        still = Command("still", np.zeros(2))
        sheet = Datasheet(tau_i=0.0, encoder_step=STEP)
        bench = Bench(folder, LAW, loop, [drive], [still], datasheet=sheet)
        own = {k: v for k, v in drive.parameters.items() if k in LAW.parameters}
        return holds(bench, [NONE, feedforward(own)])

    return held


def by_simulator(loop):
    """Return swing and reversals in the worst hold by a program that shares nothing with ours."""
    n = round(hold_time(loop, FRICTION, STEP) / T_S)
    gains = {name: getattr(loop, name) for name in ("K_p", "K_i", "K_x", "tau_f", "T_s")}
    drive = {**FRICTION, **gains, "m": AXIS.m, "b": AXIS.b, "encoder": STEP, "phase": 0.5}
    found = []
    for v_cmd in _commands(np.zeros(2), STEP, n, T_S):
        x_cmd = T_S * np.concatenate([[0.0], np.cumsum(v_cmd[:-1])])
        half = simulator.run("coulomb_stribeck", drive, v_cmd, x_cmd=x_cmd)["x"][-(n // 2) :]
        found.append((reversals(half, 0.5 * STEP), float(np.ptp(half))))
    return max(found, key=lambda one: (one[0] >= 2, one[1]))


@pytest.mark.parametrize(("K_i", "K_x"), [(4e5, 150.0), *further((1e6, 75.0), (4e5, 75.0))])
def test_stick_slip_at_rest_is_that_of_another_simulation(held, K_i, K_x):
    """When single slips happen depends on the last digits, how far they go does not."""
    loop = cascade(K_i, K_x)
    found = held(loop)
    count, swing = by_simulator(loop)
    longest = (FRICTION["F_s"] - FRICTION["F_c"]) / (loop.K_p * K_x + K_i)
    for hold in found.values():
        assert hold.hunts(2.0 * STEP)
        assert hold.swing == pytest.approx(swing, rel=0.25)
        assert abs(hold.reversals - count) <= 2
        assert 0.4 * longest < hold.swing < longest + STEP
    variant = feedforward(FRICTION)
    [warning] = hunting_at_rest(found, variant, STEP)
    assert f"swings by {1e6 * found['feedforward'].swing:.3g} um" in warning
    assert f"expected at most {2e6 * STEP:.3g} um" in warning
    assert f"{found['none'].reversals} reversals" in warning


@pytest.mark.parametrize(
    ("loop", "friction"), [(cascade(), {"F_s": FRICTION["F_c"]}), (cascade(K_i=0.0), {})]
)
def test_without_more_static_friction_or_integral_nothing_hunts(held, loop, friction):
    found = held(loop, **friction)
    assert not found["none"].hunts(2.0 * STEP)
    if not loop.K_i:  # with it, the sign of a reference that fades away decides whether it hunts
        assert hunting_at_rest(found, feedforward({**FRICTION, **friction}), STEP) == []


def test_reversals_of_a_square_wave_and_of_creep():
    t = np.arange(1000)
    noise = 0.2 * np.sin(7.0 * t)
    assert reversals(np.where(t // 100 % 2, 1.0, -1.0) + noise, 0.0) == 8
    assert reversals(1e-3 * t + 0.1 * noise, 0.0) == 0
    assert reversals(noise, 0.5) == 0
