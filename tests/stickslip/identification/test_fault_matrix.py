"""Logs with faults: a warning, a refusal, or right values; a change of friction is measured."""

import pytest

from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.estimation.faults import change_of_friction
from stickslip.identification.fitting.start import begin
from stickslip.logs import Recording
from stickslip.servo.systems import build_fmus
from tests.fault_matrix import DRIVES, learn_all, record


@pytest.mark.parametrize("name", ["Table 2", "gms", "coulomb_stribeck"])
@pytest.mark.parametrize(
    ("fault", "truth"), [("none", 0.0), ("friction drifts by 30 %", -0.3 / 0.95 / 0.85)]
)
def test_a_change_of_friction_is_found_whatever_the_law(name, fault, truth, candidates, tmp_path):
    """The mean of a friction that falls to 70 % is 85 %."""
    drive = DRIVES[name]
    build_fmus(tmp_path, {"law": drive.law, **drive.parameters})
    log, _ = record(tmp_path, drive, fault, seed=0)
    recording = Recording(*(log[column].to_numpy() for column in ("time", "position", "force")))
    with InverseModel(candidates, recording) as model:
        start = begin(model, recording)
        change, error = change_of_friction(model.over(start.space), start.line)
    assert abs(change - truth) < 3.0 * error < 0.3


@pytest.mark.slow
def test_values_of_a_drive_whose_friction_changes_are_flagged():
    rows = learn_all(("friction drifts by 30 %",), "Table 2", 0)
    assert [row["outcome"] for row in rows] == ["right", "flagged"]
