"""Friction that changes over a recording is measured, whatever the law, and flagged."""

import pytest

from campaigns.fault_matrix import DRIVES, Experiment, record
from stickslip.identification.criteria.inverse_model import InverseModel
from stickslip.identification.estimation import Task, learn
from stickslip.identification.estimation.faults import change_of_friction
from stickslip.identification.fitting.start import begin
from stickslip.logs import Recording
from stickslip.servo.systems import build_fmus
from tests.kept import further


def recorded(name, drift, folder):
    drive = DRIVES[name]
    build_fmus(folder, {"law": drive.law, **drive.parameters})
    log, _ = record(folder, drive, Experiment(drift=drift), seed=0)
    return Recording(*(log[column].to_numpy() for column in ("time", "position", "force")))


@pytest.mark.parametrize(
    ("name", "drift"),
    [
        *(("coulomb_stribeck", 0.0), ("gms", 0.3)),
        *further(("Table 2", 0.0), ("gms", 0.0), ("Table 2", 0.3), ("coulomb_stribeck", 0.3)),
    ],
)
def test_a_change_of_friction_is_found_whatever_the_law(name, drift, candidates, tmp_path):
    """The mean of a friction that falls to 70 % is 85 %."""
    truth = -drift / 0.95 / 0.85
    recording = recorded(name, drift, tmp_path)
    with InverseModel(candidates, recording) as model:
        start = begin(model, recording)
        change, error = change_of_friction(model.over(start.space), start.line)
    assert abs(change - truth) < 3.0 * error < 0.3


@pytest.mark.slow
@pytest.mark.thorough
@pytest.mark.parametrize(("drift", "flagged"), [(0.0, False), (0.3, True)])
def test_no_parameter_is_well_identified_where_friction_changes(
    drift, flagged, candidates, tmp_path
):
    learned = learn(Task(candidates, recorded("Table 2", drift, tmp_path)))
    assert any("friction changes over" in str(found) for found in learned.faults) == flagged
    assert (learned.known["m"].identifiability == "identifiable") != flagged
