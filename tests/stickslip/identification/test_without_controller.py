"""A recording whose controller is not known."""

from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from stickslip.errors import IdentificationError, UsageError
from stickslip.identification.estimation import LearnSettings, Task, learn

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def told(recorded, candidates):
    recording = recorded.learned.estimation.recording
    return watched(candidates, replace(recording, velocity_command=None))


@pytest.fixture(scope="module")
def alone(told):
    return told[0]


def watched(candidates, recording):
    """Learn; return with it the fit, what the stand-in makes of it, and whether that is alike."""
    module, seen = import_module("stickslip.identification.estimation.learn"), []
    correct = module.correct_inverse

    def spy(inverse, found, *others):
        seen.append((found, *correct(inverse, found, *others)))
        return seen[-1][1:]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "correct_inverse", spy)
        return learn(Task(candidates, recording)), seen[-1]


def test_the_inverse_model_finds_what_shows_well(alone, recorded):
    assert alone.criterion == "inverse model"
    assert "not known" in alone.reason
    for name, limit in {"m": 0.01, "F_c": 0.01, "sigma_0": 0.03, "sigma_1": 0.03}.items():
        assert alone.parameters[name] == pytest.approx(recorded.truth[name], rel=limit)


def test_it_is_less_sure_than_with_the_loop(alone, recorded):
    for name, known in alone.known.items():
        assert known.standard_error > recorded.learned.estimation.known[name].standard_error


@pytest.mark.thorough
def test_a_constant_force_changes_nothing_else(alone, candidates):
    """As on a vertical axis, whose controller bears the load when the log begins."""
    lifted = replace(alone.recording, force=alone.recording.force + 40.0)
    learned = learn(Task(candidates, lifted))
    assert abs(learned.F_0 - alone.F_0 - 40.0) < 0.02
    for name in alone.known:
        apart = learned.parameters[name] - alone.parameters[name]
        assert abs(apart) < 0.2 * alone.fitted.errors[name], name


def test_a_force_of_the_wrong_sign_is_told(recorded, candidates):
    recording = recorded.learned.estimation.recording
    turned = replace(recording, force=-np.asarray(recording.force))
    with pytest.raises(IdentificationError, match="signs"):
        learn(Task(candidates, turned))


def test_the_loop_cannot_judge_without_its_gains(recorded, candidates):
    loop = LearnSettings(law="lugre", criterion="output error")
    task = Task(candidates, recorded.learned.estimation.recording, settings=loop)
    with pytest.raises(UsageError, match="needs the controller"):
        learn(task)


def test_a_stand_in_that_shakes_the_drive_otherwise_is_not_believed(told, candidates):
    """What no replica shows, here noise on the logged force, is none of the encoder's doing."""
    quiet = told[0].recording
    noise = np.random.default_rng(0).normal(0.0, 1.0, len(quiet.t))
    shaken = watched(candidates, replace(quiet, force=quiet.force + noise))
    for (learned, (found, corrected, bias, alike)), believed in ((told, True), (shaken, False)):
        assert alike == believed
        assert bias.any()
        assert learned.fit.parameters == (corrected if alike else found).parameters
        assert learned.fitted.errors["sigma_0"] > found.errors()["sigma_0"]  # the motion tells F_c
