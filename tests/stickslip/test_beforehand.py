"""What comes out when the data sheet is wrong."""

import numpy as np
import pytest

from stickslip.catalog.parameters import LUGRE
from stickslip.evaluation.scatter import PHASES
from stickslip.evaluation.validation import validate
from stickslip.identification.stages import identify
from stickslip.papers.lugre.datasheet_errors import vary_datasheet
from stickslip.rigs.fmu import FmuRig
from stickslip.servo.datasheet import LOOP, Datasheet
from stickslip.servo.paper_commands import VALIDATION
from stickslip.servo.systems import build_fmus

pytestmark = pytest.mark.slow

WRONG = {"mass": (1.3,), "peak_force": (0.5,), "tau_i": (3.0,), "force_noise": (5.0,)}


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    build_fmus(folder, {"F_c": 5.0, "m": 6.5})
    return folder


@pytest.fixture(scope="module")
def rows(fmus):
    """Return a row for each quantity, and the first one under an empty name."""
    return vary_datasheet(fmus, "nominal", 2, WRONG).set_index("quantity")


def test_a_row_for_the_data_sheet_as_it_is_and_for_each_wrong_number(rows):
    assert list(rows.index) == ["", *WRONG]
    assert rows.value["tau_i"] == 3.0 * Datasheet().tau_i
    assert np.isnan(rows.value[""])


def test_the_first_row_is_identification_and_validation(fmus, rows):
    rig = FmuRig(fmus, Datasheet(), LOOP.T_s)
    found = identify(rig, LOOP)
    values = {name: found.estimates[name].value for name in LUGRE}
    table = validate(rig, found.loop, values, VALIDATION, phases=PHASES).table()
    table = table.query("velocity == 'measured'")
    assert rows.m[""] == found.estimates["m"].value
    assert rows.F_c[""] == pytest.approx(5.0, rel=0.01)
    columns = ["start_E_max", "start_E_rms", "reverse_E_max", "reverse_E_rms"]
    assert list(rows.loc["", columns]) == list(table["reduction"])


def test_what_identification_does_not_use_changes_nothing(rows):
    assert rows.loc["mass"].drop(["factor", "value"]).equals(rows.loc[""].drop(["factor", "value"]))
    assert rows.m["force_noise"] == rows.m[""]
    assert rows.filtered["force_noise"] != rows.filtered[""]  # the velocity filter uses it


def test_half_the_peak_force_is_enough_for_the_inertia(rows):
    assert rows.m["peak_force"] != rows.m[""]
    assert rows.m["peak_force"] == pytest.approx(6.5, rel=0.01)


def test_a_loop_that_cannot_be_designed_is_an_error_in_its_row(rows):
    assert "phase margin" in rows.error["tau_i"]
    assert rows.loc["tau_i", ["start_E_max", "filtered"]].isna().all()
    assert (rows.error.drop("tau_i") == "").all()
