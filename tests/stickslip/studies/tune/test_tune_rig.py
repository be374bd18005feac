"""Tuning on a drive: few motions, and back to the present gains at the first that is worse."""

import json
from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip.cli import main
from stickslip.errors import LimitError, UsageError
from stickslip.servo.systems import build_fmus
from stickslip.studies.learn.recorded import gains_of
from stickslip.studies.tune.run import PRESENT, TUNED
from stickslip.thresholds import kept, rig_tuning
from tests.stickslip.rigs.test_file import RIG
from tests.stickslip.rigs.test_socket import served
from tests.stickslip.studies.tune.test_tune_drive import SHEET, SLOW, learned  # noqa: F401

pytestmark = pytest.mark.slow

BRIEF = {"evaluations": 30, "seed": 1}


class Bench(ss.FmuRig):
    """A drive that remembers its commands, and that a limit may end in one of them."""

    def __init__(self, fmus, fails=None, limits=None):
        super().__init__(fmus, SHEET, SLOW.T_s, limits=limits)
        self.commands, self._fails = [], fails

    def move(self, command):
        self.commands.append(command)
        if len(self.commands) == self._fails:
            raise LimitError("following error 3 m")
        return super().move(command)


def test_the_drive_runs_few_motions_and_takes_what_helps(fmus, learned):  # noqa: F811
    rig = Bench(fmus)
    found = ss.tune(learned(), rig=rig, motions=6, **BRIEF)
    shown = found.on_rig
    assert len(shown.motions) == len(rig.commands) <= shown.budget == 6
    assert [one.loop for one in shown.motions[:3]] == 3 * [PRESENT]
    assert found.is_better
    assert found.start.observer is found.best.observer is None
    assert found.Ms[1] <= kept.SENSITIVITY
    means = {
        name: np.exp(np.mean(np.log([one.ratios for one in shown.motions if one.loop == name])))
        for name in (PRESENT, TUNED)
    }
    assert means[TUNED] < 0.9 < means[PRESENT] == pytest.approx(1.0)
    last = rig.commands[-1]
    assert gains_of(last.loop) == gains_of(found.best.loop) != gains_of(SLOW)
    moved = last.loop.commands(last.velocity)["v_cmd"]
    v = np.gradient(ss.FmuRig.move(rig, last).x_enc, rig.T_s)
    true = np.sqrt(np.mean((v - moved) ** 2))
    assert shown.motions[-1].errors[0] <= true  # low-passed, without the steps of the encoder


def test_on_another_drive_than_learned_the_present_gains_are_set_again(tmp_path, learned):  # noqa: F811
    build_fmus(tmp_path, {"m": 1.2, "tau_i": 2e-3})
    rig = Bench(tmp_path)
    found = ss.tune(learned(), rig=rig, **BRIEF)
    shown = found.on_rig
    assert not found.is_better
    assert any(one in shown.stopped for one in ("oscillates", "times that of the present loop"))
    assert "the present gains are set again" in shown.sentence
    assert len(rig.commands) == len(shown.motions) + 1 <= shown.budget
    still = rig.commands[-1]
    assert gains_of(still.loop) == gains_of(SLOW)
    assert not still.velocity.any()
    assert shown.motions[-1].loop != PRESENT
    assert all(max(one.ratios) <= rig_tuning.WORSE for one in shown.motions[:-1])


def test_a_limit_ends_it_and_one_of_the_present_loop_is_an_error(fmus, learned):  # noqa: F811
    rig = Bench(fmus, fails=3)
    found = ss.tune(learned(), rig=rig, motions=4, **BRIEF)
    assert "following error 3 m" in found.on_rig.stopped
    assert found.best is found.start
    assert len(rig.commands) == 4
    assert gains_of(rig.commands[-1].loop) == gains_of(SLOW)
    with pytest.raises(LimitError, match="following error 3 m"):
        ss.tune(learned(), rig=Bench(fmus, fails=1), motions=4, **BRIEF)


def test_what_a_rig_cannot_run_is_refused(fmus, learned):  # noqa: F811
    narrow = ss.RigLimits(travel=(-1e-6, 1e-6), speed=1.0, force=100.0, following_error=1.0)
    with pytest.raises(UsageError, match="no motion of the trial keeps the limits"):
        ss.tune(learned(), rig=Bench(fmus, limits=narrow), evaluations=12)
    slower = Bench(fmus)
    slower.T_s = 1e-3
    with pytest.raises(UsageError, match=r"T_s = 0\.0005 s, and drive\.fmu 0\.001 s"):
        ss.tune(learned(), rig=slower)
    with pytest.raises(UsageError, match="expected a learned"):
        ss.tune("loop.ssp", rig=slower)


def test_the_command_keeps_its_motions_and_writes_what_the_drive_showed(
    fmus, learned, tmp_path, capsys  # noqa: F811
):  # fmt: skip
    path = learned(replace(SLOW, K_p=SLOW.K_p))
    described, out = tmp_path / "rig.toml", tmp_path / "tuned"
    with served(fmus) as (drive, port):
        described.write_text(RIG.format(port=port))
        words = ["tune", path, "--rig", described, "--motions", 4, "--evaluations", 25]
        words = [*map(str, words), "--seed", "1", "--workers", "1", "--out", str(out)]
        for _ in range(2):  # the second takes the logs of the first
            assert main(words) == 0
            motions = drive.motion
            shown = capsys.readouterr()
        assert motions == drive.motion
    assert "an observer would have to run in the drive" in shown.err
    assert "of at most 4 motions" in shown.out
    document = json.loads((out / "tuned.json").read_text())
    assert "observer" not in document
    assert document["written"]["files"] == ["compensator.fmu"]
    assert len(document["tuning"]["on_rig"]["motions"]) == document["tuning"]["on_rig"]["used"] <= 4
    assert not (out / "observer.fmu").exists()
    assert (out / "compensator.fmu").exists()
    assert main(["tune", "--rig", str(described)]) != 0
    assert "stickslip learn --rig" in capsys.readouterr().err
