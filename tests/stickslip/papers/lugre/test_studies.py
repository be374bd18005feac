"""What a reproduction is compared with."""

from types import SimpleNamespace

import pytest

from stickslip import ga, models
from stickslip.errors import IdentificationError
from stickslip.papers.lugre import studies
from stickslip.papers.lugre.reproduction import Options
from stickslip.work.jobs import Execution


def run(tmp_path, quiet, monkeypatch, outcome):
    """Return what came out, and the call that ``reproduce`` got."""
    calls = []

    def reproduce(options, fmus, _, execution):
        calls.append((options, fmus, execution))
        assert fmus.is_dir()
        if isinstance(outcome, BaseException):
            raise outcome
        return SimpleNamespace(validation=outcome)

    monkeypatch.setattr(studies, "reproduce", reproduce)
    execution = Execution(workers=2, checkpoint=tmp_path / "kept.json", resume=True)
    options = Options(truth={"F_c": 4.0, "dac": False}, seed=3)
    monkeypatch.setattr(studies, "step_by_step", lambda *_: "step by step")
    extras = studies.reproduce_with_extras(options, tmp_path / "extras", quiet, execution)
    return extras, *calls


def test_the_drive_with_all_extras_has_every_effect_and_the_same_options(
    tmp_path, quiet, monkeypatch
):
    extras, (options, fmus, execution) = run(tmp_path, quiet, monkeypatch, "validated")
    assert (extras.table4, extras.reason) == ("step by step", "")
    booleans = {v.name for v in models.load_model("drive").variables if v.type == "boolean"}
    assert options == Options(truth={"F_c": 4.0, **dict.fromkeys(booleans, True)}, seed=3, seeds=0)
    assert {"asymmetric", "position_dependent", "ripple", "noise"} <= booleans
    assert (fmus.name, execution.workers) == ("extras", 2)


def test_a_drive_that_cannot_be_learned_with_all_extras_is_reported(tmp_path, quiet, monkeypatch):
    extras, _ = run(tmp_path, quiet, monkeypatch, IdentificationError("it sticks"))
    assert (extras.table4, extras.reason) == (None, "it sticks")


def test_ctrl_c_does_not_say_that_nothing_is_kept(tmp_path, quiet, monkeypatch):
    with pytest.raises(KeyboardInterrupt) as stopped:
        run(tmp_path, quiet, monkeypatch, ga.Interrupted(None, 3, 30))
    assert not str(stopped.value)
