"""The metrics of the arena on motions whose figures are known."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.studies.arena.drives import default_drives
from stickslip.studies.arena.metrics import Trace, figures
from stickslip.studies.arena.motion_commands import COMMANDS, RADIUS, TRAINING

T_S = 5e-4
LOOP = default_drives(["lugre"])[0].loop


def perfect(command):
    """Return a run that follows its command exactly."""
    v_cmd = command.sample(T_S)
    x_cmd = T_S * np.concatenate([[0.0], np.cumsum(v_cmd[:-1])])
    force = LOOP.axis.m * np.gradient(v_cmd, T_S) + LOOP.axis.b * v_cmd
    return Trace(T_S, v_cmd, v_cmd, x_cmd, force, v_cmd, 4e-7)


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_perfect_run_has_no_error_and_needs_no_further_force(command):
    found = figures(command, perfect(command), LOOP)
    assert abs(found["error"][0]) < 1e-15
    assert abs(found["effort"][0]) < 1e-12


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_nothing_of_it_was_tuned_on(command):
    v_cmd = command.sample(T_S)
    for one in TRAINING:
        seen = one.sample(T_S)
        length = min(len(v_cmd), len(seen))
        assert np.abs(v_cmd[:length] - seen[:length]).max() > 1e-4, one.name


def test_the_error_of_the_creep_is_relative():
    run = perfect(COMMANDS["V"])
    found = figures(COMMANDS["V"], replace(run, v=1.1 * run.v), LOOP)
    assert found["error"] == (pytest.approx(0.1), "1")
    assert found["E_rms 0.1 mm/s"][0] == pytest.approx(0.1)


def test_a_glitch_has_the_height_of_the_step_after_a_reversal():
    command = COMMANDS["C"]
    run = perfect(command)
    spans = command.motion.regions["4 rad/s"]
    assert len(spans) == 3
    late = run.x.copy()
    for k, (begin, _) in enumerate(spans):
        at = round(begin / T_S)
        assert abs(run.v_cmd[at]) < 2e-3 * np.abs(run.v_cmd).max()
        late[at + 5 : at + 100] += (k + 1) * 1e-6
    found = figures(command, replace(run, x=late), LOOP)
    assert found["quadrant glitch 4 rad/s"][0] == pytest.approx(3e-6)
    assert found["quadrant glitch 1 rad/s"][0] == pytest.approx(0.0, abs=1e-12)
    assert np.ptp(run.x_cmd) == pytest.approx(2.0 * RADIUS, rel=1e-3)


def test_a_move_settles_when_its_error_stays_within_a_micrometre():
    command = COMMANDS["M"]
    run = perfect(command)
    (begin, _), _ = command.motion.regions["10 um"]
    t = T_S * np.arange(len(run.x))
    slow = run.x + np.where(t >= begin, 1e-5 * np.exp(-(t - begin) / 0.05), 0.0)
    found = figures(command, replace(run, x=slow), LOOP)
    assert found["settling 10 um"][0] == pytest.approx(0.05 * np.log(10.0), abs=2 * T_S)
    assert found["settling 5 um"][0] == 0.0
    travelled = T_S * np.abs(run.v_cmd).sum()
    assert travelled == pytest.approx(2.0 * sum((1e-6, 2e-6, 5e-6, 1e-5, 1e-4, 1e-3)), rel=1e-3)


@pytest.mark.parametrize(("rest", "beyond"), [(0, 1e-6), (1, -2e-6)])
def test_an_overshoot_is_relative_to_the_move(rest, beyond):
    command = COMMANDS["M"]
    run = perfect(command)
    (begin, end), t = command.motion.regions["10 um"][rest], T_S * np.arange(len(run.x))
    for error, expected in ((beyond, abs(beyond) / 1e-5), (-beyond, 0.0)):
        late = run.x + np.where((t > begin + 0.1) & (t < end), error, 0.0)
        found = figures(command, replace(run, x=late), LOOP)
        assert found["overshoot 10 um"][0] == pytest.approx(expected)


def test_reversals_at_rest_are_counted_where_they_exceed_the_encoder():
    command = COMMANDS["H"]
    run = perfect(command)
    t = T_S * np.arange(len(run.x))
    for size, expected in ((3e-6, 8.0), (3e-7, 0.0)):
        # 3 s of rest see 4.5 periods, thus 9 turning points; the last one has no swing after it.
        swing = run.x + size * np.cos(
            2.0 * np.pi * 1.5 * (t - command.motion.regions["hold"][0][0])
        )
        found = figures(command, replace(run, x=swing), LOOP)
        assert found["reversals at rest"][0] == expected
        assert found["error"][0] == pytest.approx(2.0 * size, rel=0.01)
