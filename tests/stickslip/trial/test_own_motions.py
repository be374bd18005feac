"""Motions of the user, in place of those of the trial."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from stickslip.errors import RecordingError
from stickslip.identification.estimation import LearnSettings
from stickslip.logs import Column, Description, Recording, read_and_check
from stickslip.studies.learn.log_learning import with_trial
from stickslip.studies.learn.page import compensation
from stickslip.trial import own_motions
from stickslip.trial.own_motions import read_motions

T_S = 1e-3
LIKE = Recording(np.arange(9) * T_S, position=np.zeros(9))
DESCRIBED = Description(columns={"position": Column("axis_1"), "velocity_command": Column("set")})


@pytest.fixture
def motion(tmp_path):
    """Return a function that writes a motion of 1 s, sampled coarsely, and returns its path."""

    def motion(name, header, speed=2.0):
        t = np.linspace(0.0, 1.0, 251)
        columns = {"t": t, "v": speed * np.sin(np.pi * t) ** 2, "x": 0.1 * t}
        words = {"t": "time [s]", "v": "velocity_command [mm/s]", "x": "position [mm]"} | header
        path = tmp_path / f"{name}.csv"
        pd.DataFrame({words[k]: one for k, one in columns.items() if words[k]}).to_csv(path)
        return path

    return motion


@pytest.mark.parametrize(
    "header", [{"x": None}, {"v": "set [mm/s]", "x": "axis_1 [mm]"}], ids=["plan", "log"]
)
def test_a_motion_is_read_from_a_plan_or_from_a_log_as_described(motion, header):
    (found,) = read_motions([motion("press", header)], DESCRIBED, LIKE)
    assert found.name == "press"
    t = np.arange(len(found.v_cmd)) * T_S
    assert t[-1] == pytest.approx(1.0)
    np.testing.assert_allclose(found.v_cmd, 2e-3 * np.sin(np.pi * t) ** 2, atol=1e-6)


def test_what_is_no_motion_is_refused_in_a_line(motion, monkeypatch):
    still = motion("still", {"x": None}, speed=0.0)
    with pytest.raises(RecordingError, match=r"still\.csv: the command stands still"):
        read_motions([still], Description(), LIKE)
    blank = motion("blank", {"v": None, "x": None})
    with pytest.raises(RecordingError, match="no column of position or velocity or position_comm"):
        read_motions([blank], Description(), LIKE)
    turns = motion("turns", {"x": None, "v": "velocity_command [rad/s]"})
    with pytest.raises(RecordingError, match="rad/s"):
        read_motions([turns], Description(), LIKE)
    press = motion("press", {"x": None})
    monkeypatch.setattr(own_motions, "LONGEST", 1.5)
    assert len(read_motions([press], Description(), LIKE)) == 1
    with pytest.raises(RecordingError, match="take 2 s; expected at most 2 s together; cut out"):
        read_motions([press, press], Description(), LIKE)


@pytest.mark.slow
def test_compensators_are_compared_in_these_motions_alone(learned_log, log, motion):
    reading, _ = read_and_check(log, Description())
    recording = learned_log.learned.estimation.recording
    path = motion("press", {"x": None}, speed=20.0)
    own = read_motions([path], Description(), recording)
    settings = LearnSettings(compensator="static+ekbf")
    tried = with_trial(reading, replace(learned_log.learned, trial=None), settings, own)
    table = tried.trial.table()
    assert {*table["command"]} == {"press"}
    assert len({*table["drive"]}) > 5
    assert table["speed"].to_numpy() == pytest.approx(0.02, rel=1e-3)
    assert tried.trial.compared.chosen.benefit is not None
    page = compensation(tried.trial).markup({})
    assert "those that were given: press" in page
    assert "creep" not in page
    assert "creep" in compensation(replace(tried.trial, own=())).markup({})
