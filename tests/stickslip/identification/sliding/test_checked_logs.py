"""Logs of one drive, each checked with the force of position that all of them show."""

import numpy as np
import pytest

from stickslip.identification.sliding.checked_logs import Checked, check_logs
from stickslip.logs import Description, read_and_check
from stickslip.logs.sets import logs_of
from stickslip.studies.learn.log_learning import _read_all

T_S = 2e-3


def written(
    folder, name, x, *, g_s=0.0, limit=np.inf, header="time [s],position [rad],torque [Nm]"
):
    """Write the log of an arm that follows positions (n,) [rad] against its weight and friction."""
    t, v = np.arange(len(x)) * T_S, np.gradient(x, T_S)
    force = 0.05 * np.gradient(v, T_S) + 0.1 * v + 0.3 * np.sign(v) + g_s * np.sin(x)
    force += np.random.default_rng(1).normal(0.0, 0.01, len(x))
    rows = np.column_stack([t, x, np.clip(force, -limit, limit)])
    np.savetxt(folder / name, rows, delimiter=",", header=header, comments="", fmt="%.9g")
    return folder / name


def swing(amplitude, period, n=10000):
    return amplitude * np.sin(2.0 * np.pi * np.arange(n) * T_S / period)


def checked(*paths):
    return [*check_logs(logs_of(paths, Description()))]


@pytest.mark.thorough
def test_a_log_of_an_arm_is_checked_with_the_weight_that_another_shows(tmp_path):
    wide = written(tmp_path, "wide.csv", swing(3.0, 5.0), g_s=6.0)
    slow = written(tmp_path, "slow.csv", 0.5 * np.pi + swing(1.2, 20.0), g_s=6.0)
    errors = [one for one in read_and_check(slow, Description())[1] if one.severity == "error"]
    assert [one.what for one in errors] == ["force is unrelated to the motion"]
    both = checked(wide, slow)
    assert all(isinstance(one, Checked) for one in both)
    weight = both[1].reading.recording.known_force
    assert np.ptp(weight) == pytest.approx(6.0 * (1.0 - np.cos(1.2)), rel=0.02)


def test_a_faulty_log_is_left_out_of_a_set(tmp_path):
    moves = swing(1.0, 2.0, n=4000)
    for name in ("a.csv", "b.csv"):
        written(tmp_path, name, moves)
    written(tmp_path, "cut.csv", moves, limit=0.5)
    written(tmp_path, "none.csv", moves, header="time [s],position [rad],unnamed")
    logs = logs_of([tmp_path], Description())
    used, (unreadable, faulty) = _read_all(logs)
    assert [one.reading.recording.source for one in used] == ["a.csv", "b.csv"]
    assert "1 of 4 logs left out" in unreadable.what
    assert "none.csv" in unreadable.figure
    assert "cut.csv: warning: the force in the log is cut off" in faulty.figure
    assert not unreadable.spoils
    assert not faulty.spoils
    kept, left_out = _read_all([logs[0], logs[2]])  # no two logs without a fault
    assert (len(kept), left_out) == (2, ())
