"""A drive of a law that is not LuGre, in a position loop, against what is true of it."""

import pytest

from campaigns.random_drives import random_drive, record
from stickslip.identification.estimation import LearnSettings, Task, candidate_fmus, learn


@pytest.mark.thorough
def test_a_drive_that_sticks_and_slips_is_learned_within_intervals():
    drive = random_drive(27, cascade=True, sound=True)
    assert (drive.law, bool(drive.K_x)) == ("coulomb_stribeck", True)
    recording, gains = record(drive, 27)
    with candidate_fmus(drive.law) as fmus:
        learned = learn(Task(fmus, recording, gains, LearnSettings(law=drive.law, seed=27)))
    for name, known in learned.known.items():
        assert known.low <= drive.parameters[name] <= known.high, (name, known)
    assert {learned.known[name].identifiability for name in ("m", "F_c")} == {"identifiable"}
