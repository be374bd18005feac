"""The benchmark that counts how often intervals hold the truth."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from campaigns.interval_coverage import _rows, draw, drive
from stickslip.catalog.parameters import PAPER, friction_law
from stickslip.identification.estimation import Identifiability
from tests.random_drives import RandomDrive


@pytest.mark.parametrize(("low", "high", "holds"), [(5.9, 6.1, True), (6.0, 6.1, False)])
def test_an_interval_holds_the_truth_or_not(low, high, holds):
    known = {"F_c": Identifiability(0.5 * (low + high), 0.05, low, high, "identifiable", "")}
    estimation = SimpleNamespace(
        recording=SimpleNamespace(position=np.linspace(0.0, 0.1, 100)),
        known=known,
        law=friction_law(),
        friction_curve=None,
    )
    (row,) = _rows(RandomDrive(parameters=PAPER), estimation)
    assert row["holds"] is holds
    assert row["truth"] == PAPER["F_c"]


def test_varied_drives_differ_but_for_the_same_seed():
    drives = [drive("varied", seed) for seed in range(50)]
    assert drive("same", 3) == PAPER
    assert drives[7] == drive("varied", 7)
    for name in ("m", "F_c", "F_s", "sigma_0", "sigma_1"):
        assert len({one[name] for one in drives}) == len(drives)
    assert all(one["F_s"] > one["F_c"] > 0.0 for one in drives)


def test_the_picture_can_be_drawn_of_one_recording_and_of_many():
    rows = pd.DataFrame(
        {"parameter": "F_c", "truth": 6.0, "low": 5.9, "value": 6.0, "high": 6.1, "holds": True},
        index=range(40),
    ).assign(holds=np.arange(40) > 0)
    for table in (rows[:1], rows):
        assert draw(table).startswith(b"\x89PNG")
