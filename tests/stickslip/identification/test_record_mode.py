"""One recording of 20 s is enough for the compensator, and says how well it knows it."""

import json

import numpy as np
import pytest

from stickslip import cosim
from stickslip.catalog.parameters import UNITS
from stickslip.logs import load_description, read_recording
from stickslip.papers.lugre.record import RECORD_FILES, write_record_results
from stickslip.rigs.contract import commissioning_loop
from stickslip.servo.axis import Datasheet
from stickslip.studies.learn.recorded import record_drive

pytestmark = pytest.mark.slow

LIMITS = {"F_c": 0.005, "sigma_0": 0.05, "sigma_1": 0.05, "m": 0.005, "F_s": 0.05, "v_s": 0.1}


def test_parameters_are_found(recorded):
    table = recorded.table2().set_index("parameter")
    for name, limit in LIMITS.items():
        assert table.learned[name] == pytest.approx(table.drive[name], rel=limit), name


def test_the_known_loop_judges_and_its_residual_is_what_encoder_and_noise_explain(recorded):
    assert recorded.learned.estimation.criterion == "output error"
    assert "controller is known" in recorded.learned.estimation.reason
    assert recorded.learned.estimation.model_error < 2.0


def test_intervals_surround_their_values_and_most_hold_the_truth(recorded):
    table = recorded.table2()
    assert ((table["low"] < table["learned"]) & (table["learned"] < table["high"])).all()
    # Factor 2 on the 95 % interval: a miss there would be one in ten thousand.
    middle, half = table["learned"], (table["high"] - table["low"])
    assert (np.abs(table["drive"] - middle) < half).all()


def test_tracking_errors_fall(recorded):
    """The measured ones keep the noise of this drive's encoder."""
    table = recorded.validation.table().set_index("velocity")
    assert (table.reduction["measured"] > 0.85).all()
    assert (table.reduction["true"] > 0.9).all()


def test_the_commissioning_loop_bears_a_third_and_three_times_its_mass(make_rig):
    for mass in (5.5 / 3.0, 5.5 * 3.0):
        recording = record_drive(make_rig(m=mass))
        assert np.abs(recording.force).max() < 100.0
        assert np.abs(np.gradient(recording.position, recording.T_s)).max() < 0.08


def test_nothing_but_measurements_leaves_the_drive(make_rig, monkeypatch):
    rig, seen, prepare = make_rig(F_c=7.0), [], cosim.Simulation.__init__

    def watch(self, specification):
        seen.append(specification)
        prepare(self, specification)

    monkeypatch.setattr(cosim.Simulation, "__init__", watch)
    record_drive(rig)
    (specification,) = seen
    assert set(specification.record) == {"drive.x_enc", "drive.F_m"}
    assert not [name for name in specification.system.parameters if name.startswith("drive.")]


@pytest.mark.usefixtures("without_pictures")
def test_the_written_recording_is_the_recording(recorded, tmp_path):
    write_record_results(recorded, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {*RECORD_FILES, "manifest.json"}
    description = load_description(tmp_path / "recording.toml")
    reading = read_recording(tmp_path / "recording.csv", description)
    recording = recorded.learned.estimation.recording
    np.testing.assert_allclose(reading.recording.position, recording.position, atol=1e-15)
    np.testing.assert_allclose(reading.recording.force, recording.force, atol=1e-12)
    gains = reading.controller.parameters()
    assert gains["K_p"] == pytest.approx(commissioning_loop(Datasheet()).K_p)
    document = json.loads((tmp_path / "learned.json").read_text())
    assert set(document["parameters"]) == set(UNITS)
    for name, entry in document["parameters"].items():
        assert entry["low"] < entry["value"] < entry["high"], name
    assert (tmp_path / "report.html").exists()
