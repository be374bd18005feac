"""A drive of a law that is not LuGre, in a position loop, against what is true of it."""

from dataclasses import replace

import pytest

import stickslip as ss
from campaigns.sound_drives.drives import draw, write_log


@pytest.mark.thorough
def test_a_drive_that_sticks_and_slips_is_learned_within_intervals(tmp_path):
    drive = draw(1, 34)
    assert (drive.law, drive.controller) == ("coulomb_stribeck", "P-PI")
    even = {"uneven": 0.0, "asymmetry": 0.0, "F_0": 0.0}
    drive = write_log(replace(drive, parameters={**drive.parameters, **even}), tmp_path)
    known = ss.Description(controller=drive.controller, gains=drive.gains)
    learned = ss.learn(tmp_path / f"{drive.name}.csv", known, law=drive.law)
    found = learned.estimation.known
    for name, truth in drive.truth.items():
        assert found[name].low <= truth <= found[name].high, (name, found[name])
    assert {found[name].identifiability for name in ("m", "F_c")} == {"identifiable"}
