"""Drives and controllers that are not this project's: simulated here in plain Python.

The bristle and the mass are solved by implicit Euler, in steps of 10 us or less.
"""

import math
from importlib import import_module

import numpy as np
import pytest

from stickslip.identification.criteria.motion import recording_scale
from stickslip.identification.estimation import Task, learn
from stickslip.logs import Recording

pytestmark = pytest.mark.slow

T_S, SUB = 1e-3, 100
DRIVE = {"m": 12.5, "b": 40.0, "F_c": 17.0, "F_s": 24.0, "v_s": 2e-3, "sigma_0": 7e5}
DRIVE["sigma_1"] = 0.8 * math.sqrt(DRIVE["sigma_0"] * DRIVE["m"])
GAINS = {"K_p": 900.0, "K_i": 15000.0, "tau_f": 2e-3, "T_s": T_S}


def command(duration):
    """Fast moves with rests between them, then slow reversals and presliding."""
    t = T_S * np.arange(round(duration / T_S))
    early = t < 0.5 * duration
    moves = 0.05 * np.clip(1.6 * np.sin(2.0 * np.pi * t), -1.0, 1.0) * (np.sin(1.6 * t) > -0.4)
    slow = 3e-3 * np.sin(3.0 * t) + 4e-4 * np.sin(23.0 * t)
    return t, np.where(early, moves, slow)


def recorded(delta, encoder, duration=14.0, sub=SUB, pull=0.0, held=0.0, skipped=0):
    """Position and force of a PI of velocity whose integral runs behind (forward Euler).

    A force pulls at the drive, the integral holds one at first; the log lacks the first samples.
    """
    t, v_cmd = command(duration)
    p, h = DRIVE, T_S / sub
    weight = 1.0 - math.exp(-T_S / GAINS["tau_f"])
    x = v = z = v_est = last = 0.0
    integral = held
    position, force = np.empty(len(t)), np.empty(len(t))
    for k, wanted in enumerate(v_cmd.tolist()):
        shown = round(x / encoder) * encoder if encoder else x
        v_est += weight * ((shown - last) / T_S - v_est)
        last = shown
        u = GAINS["K_p"] * (wanted - v_est) + integral
        integral += T_S * GAINS["K_i"] * (wanted - v_est)
        position[k], force[k] = shown, u
        for _ in range(sub):
            fall = math.exp(-((abs(v) / p["v_s"]) ** delta))
            lost = 1.0 + h * p["sigma_0"] * abs(v) / (p["F_c"] + (p["F_s"] - p["F_c"]) * fall)
            old = p["sigma_0"] * z / lost + p["sigma_1"] * (z / lost - z) / h
            new = (p["sigma_0"] * h + p["sigma_1"]) / lost
            v = (v + h / p["m"] * (u - pull - old)) / (1.0 + h / p["m"] * (p["b"] + new))
            z = (z + h * v) / lost
            x += h * v
    position, force, v_cmd = position[skipped:], force[skipped:], v_cmd[skipped:]
    return Recording(
        t[: len(t) - skipped],
        position,
        force=force,
        velocity_command=v_cmd,
        encoder_step=encoder,
        source="elsewhere",
    )


@pytest.mark.parametrize(
    ("delta", "pull", "held", "skipped"),
    [
        (1.0, 100.0, 100.0, 0),
        pytest.param(2.0, 0.0, 0.0, 1100, marks=pytest.mark.thorough),
    ],
)
def test_the_loop_gives_the_exponent_and_all_parameters(delta, pull, held, skipped, candidates):
    """On a vertical axis that was held before the log began; in a log that begins in motion."""
    recording = recorded(delta, 1e-6, pull=pull, held=held, skipped=skipped)
    learned = learn(Task(candidates, recording, GAINS))
    assert learned.criterion == "output error"
    assert "integral by forward Euler and was running when the log began" in learned.reason
    assert learned.compensator["delta"] == delta
    assert abs(learned.F_0 - pull) < 0.5
    for name, value in DRIVE.items():
        assert learned.parameters[name] == pytest.approx(value, rel=0.03), name


def test_wherever_the_search_ends_the_mean_force_finds_the_valley(candidates, monkeypatch):
    """Here it ended where bristles are too stiff to be seen, on a drive that rests for long."""
    module = import_module("stickslip.identification.estimation.learn")

    def stuck(_inverse, start, _best):
        stiff = {"F_c": 0.3, "F_s": 0.7, "v_s": 100.0, "sigma_0": 300.0, "sigma_1": 0.04}
        return {**start.line, **{name: by * start.line[name] for name, by in stiff.items()}}

    monkeypatch.setattr(module, "solve_linear", stuck)
    recording = recorded(1.0, 1e-7)
    learned = learn(Task(candidates, recording))
    assert learned.criterion == "inverse model"
    found = recording_scale(recording).restored(learned.fit.parameters)
    for name in ("m", "F_c", "F_s", "sigma_0"):
        assert found[name] == pytest.approx(DRIVE[name], rel=0.06), name


@pytest.mark.thorough
def test_a_log_of_another_simulation_is_judged_by_its_loop(candidates):
    """Without encoder and noise only both programs' own errors are left."""
    learned = learn(Task(candidates, recorded(1.0, 0.0, 6.0, sub=500), GAINS))
    assert learned.criterion == "output error"
    for name, value in DRIVE.items():
        assert learned.parameters[name] == pytest.approx(value, rel=0.01), name
