"""A force that stays at its extreme is limited only where more is asked for."""

import math
from dataclasses import replace

import numpy as np
import pytest

from stickslip.logs import Recording, check_recording

T_S, N = 1e-3, 12_000
T = np.arange(N) * T_S
TRAPEZOID = 0.1 * np.clip(8.0 * np.sin(2 * np.pi * 0.25 * T), -1.0, 1.0)


def run(force=None, b=0.0, limits=(-math.inf, math.inf), m=3.0, F_c=6.0) -> Recording:
    """Simulate a drive under a force (n,), or in a PI velocity loop that follows ``TRAPEZOID``."""
    x = v = F = total = 0.0
    log = np.empty((N, 3))
    for k in range(N):
        error = TRAPEZOID[k] - v
        command = 200.0 * m * error + total if force is None else force[k]
        applied = min(max(command, limits[0]), limits[1])
        total += 6000.0 * m * T_S * error * (applied == command)
        for _ in range(10):
            F += 0.1 * (applied - F)
            v += 0.1 * T_S / m * (F - b * v - F_c * math.tanh(v / 2e-4))
            x += 0.1 * T_S * v
        log[k] = round(x / 1e-7) * 1e-7, F, command
    x, F, command = log.T
    command = {"velocity_command": TRAPEZOID} if force is None else {"force_command": command}
    return Recording(T, x, F, **command, encoder_step=1e-7)


def said(recording) -> str:
    found = check_recording(recording)
    return "\n".join(str(one) for one in found if "saturates" in one.what or "cut off" in one.what)


EXPERIMENTS = {
    "trapezoids with Coulomb friction alone": {},
    "bang-bang force": {"force": 14.0 * np.sign(np.sin(2 * np.pi * (0.3 * T + 0.04 * T**2)))},
    "steps of force": {
        "force": np.repeat([12, -9, 18, -18, 18, -10, 15, -12, 18, -18], N // 10) * 1.0, "b": 90.0,
    },
}  # fmt: skip


@pytest.mark.parametrize("name", EXPERIMENTS)
def test_a_plateau_that_was_commanded_is_no_limit(name):
    """Its force stays at an extreme for a long time, in a log with and without the command."""
    log = run(**EXPERIMENTS[name])
    assert np.mean(np.abs(log.force) > 0.98 * np.quantile(np.abs(log.force), 0.98)) > 0.01
    for force in (log.force, np.round(log.force / 0.5) * 0.5):
        for change in ({}, {"force_command": None, "velocity_command": None}):
            assert said(replace(log, force=force, **change)) == ""


@pytest.mark.parametrize("limits", [(-7.5, 7.5), (-math.inf, 7.5), (-7.5, math.inf)])
@pytest.mark.parametrize("noise", [0.0, 0.03])
def test_a_limit_is_found_where_the_error_of_the_motion_grows(limits, noise):
    log = run(limits=limits)
    noise = noise * np.random.default_rng(0).standard_normal(N)
    found = said(replace(log, force=log.force + noise))
    assert float(found.split("saturates at ")[1].split(":")[0]) == pytest.approx(7.5, rel=0.02)


def test_a_limit_is_found_where_the_force_command_is_larger():
    command = 16.0 * np.sin(2 * np.pi * (0.3 * T + 0.04 * T**2))
    log = run(command, b=90.0, limits=(-11.0, 13.0))
    told = said(log).split("saturates at 13: ")[1]
    share = np.mean((log.force > 12.8) | (log.force < -10.8))
    assert float(told.split("%")[0]) == pytest.approx(100 * share, rel=0.1)
    assert "saturates" not in said(replace(log, force_command=log.force))
