"""Drives of laws that are not LuGre, in position loops, against what is true of them."""

import pytest

from stickslip.identification.estimation import Task, candidate_fmus, learn
from tests.random_drives import random_drive, record


@pytest.mark.parametrize(
    ("seed", "cascade"),
    [(27, True), (5, True)],
    ids=["Coulomb-Stribeck in a position loop", "Dahl in a position loop"],
)
def test_intervals_hold_the_truth(seed, cascade):
    drive = random_drive(seed, cascade=cascade, sound=True)
    recording, gains = record(drive, seed)
    with candidate_fmus(drive.law) as fmus:
        learned = learn(Task(fmus, recording, gains, law=drive.law, seed=seed))
    for name, known in learned.known.items():
        assert known.low <= drive.parameters[name] <= known.high, (name, known)
    assert learned.known["F_c"].identifiability == "identifiable"
    assert learned.known["m"].identifiability == "identifiable"
