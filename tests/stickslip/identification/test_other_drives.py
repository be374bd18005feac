"""A drive and a controller that are not this project's, in a log of fast moves and presliding."""

import math
from importlib import import_module

import numpy as np
import pytest

from campaigns.sound_drives import simulator
from stickslip.identification.criteria.motion import recording_scale
from stickslip.identification.estimation import Task, learn
from stickslip.logs import Recording

pytestmark = pytest.mark.slow

T_S, DURATION = 1e-3, 8.0
DRIVE = {"m": 12.5, "b": 40.0, "F_c": 17.0, "F_s": 24.0, "v_s": 2e-3, "sigma_0": 7e5}
DRIVE["sigma_1"] = 0.8 * math.sqrt(DRIVE["sigma_0"] * DRIVE["m"])
GAINS = {"K_p": 900.0, "K_i": 15000.0, "tau_f": 2e-3, "T_s": T_S}


def recorded(encoder, skipped=0, **changes):
    """Return moves with rests between them, then slow reversals and presliding.

    The log lacks the first samples.
    """
    t = T_S * np.arange(round(DURATION / T_S))
    moves = 0.05 * np.clip(1.6 * np.sin(2.0 * np.pi * t), -1.0, 1.0) * (np.sin(1.6 * t) > -0.4)
    slow = 3e-3 * np.sin(3.0 * t) + 4e-4 * np.sin(23.0 * t)
    v_cmd = np.where(t < 0.5 * DURATION, moves, slow)
    found = simulator.run("lugre", {**DRIVE, **GAINS, "encoder": encoder, **changes}, v_cmd)
    signals = {"force": found["commanded"][skipped:], "velocity_command": v_cmd[skipped:]}
    position = found["encoder"][skipped:]
    return Recording(
        t[: len(position)], position, **signals, encoder_step=encoder, source="elsewhere"
    )


@pytest.mark.parametrize(
    ("delta", "pull", "skipped"),
    [(1.0, 100.0, 0), pytest.param(2.0, 0.0, 1100, marks=pytest.mark.thorough)],
)
def test_the_loop_gives_the_exponent_and_all_parameters(delta, pull, skipped, candidates):
    """On a vertical axis that was held before the log began; in a log that begins in motion."""
    held = {"F_0": pull, "held": pull, "motor": pull}
    learned = learn(Task(candidates, recorded(1e-6, skipped, delta=delta, **held), GAINS))
    assert learned.criterion == "output error"
    assert "was running when the log began" in learned.reason
    assert learned.compensator["delta"] == delta
    assert abs(learned.parameters["F_0"] - pull) < 0.5
    for name, value in DRIVE.items():
        assert learned.parameters[name] == pytest.approx(value, rel=0.03), name


@pytest.mark.thorough
def test_wherever_the_search_ends_the_mean_force_finds_the_valley(candidates, monkeypatch):
    """Here it ended where bristles are too stiff to be seen, on a drive that rests for long."""
    module = import_module("stickslip.identification.estimation.learn")

    def stuck(_inverse, start, _best):
        stiff = {"F_c": 0.3, "F_s": 0.7, "v_s": 100.0, "sigma_0": 300.0, "sigma_1": 0.04}
        return {**start.line, **{name: by * start.line[name] for name, by in stiff.items()}}

    monkeypatch.setattr(module, "solve_linear", stuck)
    recording = recorded(1e-7)
    learned = learn(Task(candidates, recording))
    assert learned.criterion == "inverse model"
    found = recording_scale(recording).restored(learned.fit.parameters)
    for name in ("m", "F_c", "F_s", "sigma_0"):
        assert found[name] == pytest.approx(DRIVE[name], rel=0.06), name
