"""Logs are kept, and no motion is run twice unless somebody asks for it."""

from dataclasses import replace

import numpy as np
import pytest

from stickslip import Datasheet, KeptRig
from stickslip.errors import LimitError, RigError
from tests.stickslip.rigs.test_contract import WIDE, Ideal


class Interrupted(Ideal):
    """A drive whose program dies in one of its motions, while it moves."""

    def __init__(self, number):
        super().__init__(WIDE)
        self.number = number

    def move(self, command):
        log = super().move(command)
        if self.moved == self.number:
            raise KeyboardInterrupt
        return log


def experiment(rig, last=0.04):
    """Run three motions, each of which follows from the log before."""
    x = 0.01
    for v in (0.02, 0.03, last):
        x = rig.follow(np.full(100, v + x), rig.loop).x_enc[-1]
    return x


def test_what_was_done_is_not_done_again_and_the_interrupted_motion_only_when_asked(tmp_path):
    expected = experiment(Ideal(WIDE))
    with pytest.raises(KeyboardInterrupt):
        experiment(KeptRig(Interrupted(2), tmp_path))
    drive = Ideal(WIDE)
    begun = tmp_path / "motion-0002.json"
    with pytest.raises(RigError, match=r"motion-0002\.json: motion 2 of 0\.05 s was begun and has"):
        experiment(KeptRig(drive, tmp_path))
    assert not drive.moved
    begun.unlink()
    assert experiment(KeptRig(drive, tmp_path)) == expected
    assert drive.moved == 2
    assert experiment(KeptRig(drive, tmp_path)) == expected
    assert drive.moved == 2


def test_a_folder_of_another_run_is_refused(tmp_path):
    experiment(KeptRig(Ideal(WIDE), tmp_path))
    drive = Ideal(WIDE)
    with pytest.raises(RigError, match=r"motion-0003\.npz: is of another command than motion 3"):
        experiment(KeptRig(drive, tmp_path), last=0.05)
    assert not drive.moved


def test_a_limit_that_aborted_a_motion_does_so_again_without_it(tmp_path):
    for moved in (1, 0):
        drive = Ideal(WIDE)
        kept = KeptRig(drive, tmp_path)
        if moved:
            drive.move = lambda _, drive=drive: aborted(drive)
        with pytest.raises(LimitError, match="speed 2 m/s"):
            kept.follow(np.full(100, 0.5), kept.loop)
        assert drive.moved == moved


def aborted(drive):
    drive.moved += 1
    raise LimitError("speed 2 m/s")


def test_a_folder_of_another_rig_is_refused_and_what_is_taken_is_said(tmp_path, caplog):
    experiment(KeptRig(Ideal(WIDE), tmp_path))
    assert not caplog.messages
    experiment(KeptRig(Ideal(WIDE), tmp_path))
    said = [f"motion {k} is taken from {tmp_path}; the drive was not moved" for k in (1, 2, 3)]
    assert caplog.messages == said
    for change, named in [
        ({"name": "x-axis"}, "name drive; expected x-axis. Give another folder"),
        ({"datasheet": Datasheet(mass=9.0)}, "datasheet .*'mass': 5.5.*; expected .*'mass': 9.0"),
        ({"limits": replace(WIDE, force=200.0)}, "limits .*'force': 300.0.*; expected .*200.0"),
    ]:
        drive = Ideal(WIDE)
        vars(drive).update(change)
        with pytest.raises(RigError, match=rf"motion-0001\.npz: is of another rig: {named}"):
            experiment(KeptRig(drive, tmp_path))
        assert not drive.moved
