"""A drive of a law that is not LuGre, in a position loop, against what is true of it."""

import pytest

import stickslip as ss
from campaigns.sound_drives.__main__ import recorded


@pytest.mark.thorough
def test_a_drive_that_sticks_and_slips_is_learned_within_intervals(tmp_path):
    drive = recorded(1, 14, tmp_path)
    assert (drive.law, bool(drive.parameters["K_x"])) == ("coulomb_stribeck", True)
    known = ss.Description(controller="P-PI", gains=drive.gains)
    learned = ss.learn(tmp_path / f"{drive.name}.csv", known, law=drive.law)
    for name, truth in drive.truth.items():
        found = learned.estimation.known[name]
        assert found.low <= truth <= found.high, (name, found)
