"""A recording whose controller is not known."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip.errors import IdentificationError, UsageError
from stickslip.estimation import Task, learn
from stickslip.estimation.inverse import InverseModel
from stickslip.estimation.stand_in import coarse


@pytest.fixture(scope="module")
def alone(recorded, candidates):
    recording = replace(recorded.estimation.recording, velocity_command=None)
    return learn(Task(candidates, recording))


def test_the_inverse_model_finds_what_shows_well(alone, recorded):
    assert alone.judge == "inverse model"
    assert "not known" in alone.reason
    for name, limit in {"m": 0.01, "F_c": 0.01, "sigma_0": 0.03, "sigma_1": 0.03}.items():
        assert alone.parameters[name] == pytest.approx(recorded.truth[name], rel=limit)


def test_it_is_less_sure_than_with_the_loop(alone, recorded):
    for name, known in alone.known.items():
        assert known.standard_error > recorded.estimation.known[name].standard_error


def test_an_encoder_counts_as_coarse_by_its_step(recorded, candidates):
    recording = recorded.estimation.recording
    with InverseModel(candidates, recording) as model:
        assert coarse(model, recording)
        assert not coarse(model, replace(recording, encoder_step=1e-9))


def test_a_force_of_the_wrong_sign_is_told(recorded, candidates):
    recording = recorded.estimation.recording
    turned = replace(recording, force=-np.asarray(recording.force))
    with pytest.raises(IdentificationError, match="signs"):
        learn(Task(candidates, turned))


def test_the_loop_cannot_judge_without_its_gains(recorded, candidates):
    task = Task(candidates, recorded.estimation.recording, judge="output error")
    with pytest.raises(UsageError, match="needs the controller"):
        learn(task)
