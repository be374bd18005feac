"""What is learned of a drive with another friction law never makes that drive worse."""

import numpy as np
import pandas as pd
import pytest

from campaigns.never_worse import DRIVES, WORSE, learn, tried
from stickslip.learned.file import LearnedFile
from stickslip.studies.learn.folder import write_learned

pytestmark = [pytest.mark.slow, pytest.mark.thorough]


@pytest.fixture(scope="module")
def learned(tmp_path_factory):
    """LuGre learned of a drive with five Maxwell-slip elements and position dependence."""
    return learn(DRIVES["gms"], "lugre", tmp_path_factory.mktemp("log") / "log.csv")


def test_f_s_that_does_not_show_is_f_c(learned):
    """The fit prefers 20 times F_c here; such a force pushed the drive."""
    estimation = learned.estimation
    fitted = estimation.fitted.plausible[0]
    assert fitted["F_s"] > 10.0 * fitted["F_c"]
    assert estimation.fitted.largest_friction == pytest.approx(8.999, rel=0.1)
    assert estimation.known["F_s"].identifiability == "not identifiable"
    assert learned.friction["F_s"] == learned.friction["F_c"] == estimation.known["F_c"].value
    assert "F_s = F_c is used" in estimation.known["F_s"].sentence
    assert learned.friction["F_c"] == pytest.approx(5.999, rel=0.15)


def test_the_drive_is_not_worse_with_what_is_written_but_with_the_fit(learned):
    assert not learned.refusal
    written = dict(tried(DRIVES["gms"], "lugre", learned.compensator))
    assert max(written.values()) <= WORSE
    assert np.exp(np.mean(np.log(list(written.values())))) < 0.75
    fit = {name: learned.estimation.fitted.plausible[0][name] for name in learned.friction}
    assert any(ratio > WORSE for _, ratio in tried(DRIVES["gms"], "lugre", fit))


def test_no_drive_of_the_family_is_beyond_the_log(learned):
    drives = learned.trial.drives
    assert {"lugre", "gms"} <= {drive.law for drive in drives}
    most = 1.5 * 1.3 * learned.estimation.fitted.largest_friction
    assert max(drive.parameters.get("F_s", 0.0) for drive in drives) <= most


@pytest.mark.usefixtures("without_pictures")
def test_export_tries_the_same_drives(learned, tmp_path):
    write_learned(learned, tmp_path)
    file = LearnedFile(tmp_path / "learned.json")
    assert file.drives == learned.trial.drives
    assert file.compensator == pytest.approx(learned.compensator)
    table = pd.read_csv(tmp_path / "tracking_error.csv")
    assert len(table) == (1 + len(learned.trial.others)) * 5 * len(learned.trial.drives)
    written = table[table["compensation"] == learned.trial.benefit.variant.name]
    assert (written["ratio"] <= WORSE).all()
