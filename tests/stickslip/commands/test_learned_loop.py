"""learned.json carries the loop, and export of a compensator looks at it."""

import json

import numpy as np
import pytest

from stickslip import cosim
from stickslip.catalog.parameters import LUGRE, PAPER, UNITS
from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.evaluation.motions import VALIDATION
from stickslip.learned.file import LearnedFile
from stickslip.learned.writing import loop_document, validation_document
from stickslip.servo.axis import LOOP, Axis, Datasheet
from stickslip.servo.tuned_pi import with_inertia, with_velocity_filter
from stickslip.servo.velocity_loop import close_velocity_loop, design_velocity_loop
from stickslip.storage.codec import encode

pytestmark = pytest.mark.slow

AXIS = Axis(5.557, 6.6135, 1e-4)
LOOPS = {
    "paper": design_velocity_loop(AXIS, LOOP),
    "weak": close_velocity_loop(AXIS, 5e-4, 5e-4, 200.0, 2000.0),
}
LOOPS["filter"] = with_inertia(with_velocity_filter(LOOPS["paper"], Datasheet(), 6.0))
SLOW = cosim.Trapezoid(height=5e-4, slope=0.01, plateau=1.0, begin=0.1)


@pytest.fixture
def learned(tmp_path):
    """Write a learned.json with Table 2 and more entries; return its path."""

    def write(**entries):
        parameters = {name: {"value": PAPER[name], "standard_error": None} for name in LUGRE}
        path = tmp_path / "learned.json"
        path.write_text(json.dumps({"parameters": parameters, **entries}))
        return path

    return write


def export(path, folder, *more):
    return main(["export", "compensator", "--parameters", str(path), "--out", str(folder), *more])


@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_comes_back_as_it_was(learned, name):
    loop = LOOPS[name]
    again = LearnedFile(learned(loop=loop_document(loop))).loop
    assert again.axis == loop.axis
    assert again.velocity_filter == loop.velocity_filter
    for matrix in ("A", "B", "C", "D"):
        np.testing.assert_array_equal(getattr(again.nominal, matrix), getattr(loop.nominal, matrix))
    np.testing.assert_array_equal(again.acceleration.B, loop.acceleration.B)


def test_what_an_older_file_lacks_has_a_default_and_the_rest_comes_back(learned):
    file = LearnedFile(learned())
    assert (file.loop, file.feed, file.standard_errors) == (None, "nominal", {})
    assert (file.validation, file.datasheet) == (VALIDATION, Datasheet())
    assert LearnedFile(learned(validation=validation_document(SLOW))).validation == SLOW
    sheet = Datasheet(peak_force=40.0, tau_i=0.0, encoder_step=1e-6)
    assert LearnedFile(learned(datasheet=encode(sheet))).datasheet == sheet
    with pytest.raises(UsageError, match="datasheet: expected peak_force, tau_i, encoder_step"):
        assert LearnedFile(learned(datasheet={"encoder_step": {"value": -1.0}})).datasheet


@pytest.mark.parametrize("schema", [0, 3, True, "2", None, 1.5])
def test_a_file_of_another_schema_is_refused_in_one_line(learned, schema):
    message = "schema: expected a number from 1 to 2, got .*; read it with the version"
    with pytest.raises(UsageError, match=message):
        LearnedFile(learned(schema=schema))
    assert LearnedFile(learned(schema=2)).friction == LearnedFile(learned()).friction


def start_of(path, name):
    return cosim.Fmu(path).variables[name].start


def test_export_reduces_a_force_that_would_hurt_a_drive_of_the_file(learned, tmp_path, capsys):
    half = {
        n: {"value": (0.5 if UNITS[n] != "m/s" else 1.0) * PAPER[n], "unit": UNITS[n]}
        for n in LUGRE
    }
    family = [{"drive": "half the friction", "law": "lugre", "parameters": half, "level": 0.5}]
    path = learned(loop=loop_document(LOOPS["paper"]), family=family)
    assert export(path, tmp_path) == 0
    [line] = capsys.readouterr().err.splitlines()
    share = float(line.split("warning: ")[1].split(" of the force is exported")[0])
    assert "with 0.5 times the friction" in line
    assert 0.5 <= share < 1.0
    fmu = tmp_path / "compensator.fmu"
    assert start_of(fmu, "F_c") == pytest.approx(share * PAPER["F_c"], rel=1e-12)
    assert start_of(fmu, "v_s") == PAPER["v_s"]
    assert export(path, tmp_path, "--force") == 0
    assert "the whole force is exported" in capsys.readouterr().err
    assert start_of(fmu, "F_c") == PAPER["F_c"]


@pytest.mark.parametrize("entries", [{"loop": loop_document(LOOPS["paper"])}, {}])
def test_force_exports_the_whole_force_whatever_share_the_file_has(
    learned, tmp_path, capsys, entries
):
    path = learned(**entries, share={"value": 0.6}, tracking_error=[{"ratio": 0.5}])
    fmu = tmp_path / "compensator.fmu"
    for options, share in (((), 0.6), (("--force",), 1.0)):
        assert export(path, tmp_path, *options) == 0
        assert start_of(fmu, "F_c") == pytest.approx(share * PAPER["F_c"])
        told = "the whole force is exported, as --force asks for, not 0.6 of it"
        assert (told in capsys.readouterr().err) == bool(options)


def test_export_of_what_was_never_tried_is_refused_and_forced(learned, tmp_path, capsys):
    fmu = tmp_path / "compensator.fmu"
    refusal = "it was not tried, because no velocity loop can be closed"
    for entries, why in (({}, "neither a loop"), ({"refusal": refusal}, refusal)):
        path = learned(**entries)
        assert export(path, tmp_path) == 1
        assert why in capsys.readouterr().err
        assert not fmu.exists()
        assert export(path, tmp_path, "--force") == 0
        assert f"{why}" in capsys.readouterr().err
        fmu.unlink()
    assert export(learned(tracking_error=[{"ratio": 0.5}]), tmp_path) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert "the force is that of the velocity command" in line


def test_export_refuses_what_makes_the_loop_worse_unless_forced(learned, tmp_path, capsys):
    """A log that also supports a drive with a hundredth of the friction."""
    friction = {**{name: PAPER[name] for name in LUGRE}, "F_c": 0.06, "F_s": 0.09}
    slippery = {name: {"value": value, "unit": UNITS[name]} for name, value in friction.items()}
    entry = {"drive": "hardly any friction", "law": "lugre", "parameters": slippery}
    path = learned(loop=loop_document(LOOPS["paper"]), family=[entry])
    assert export(path, tmp_path) == 1
    lines = capsys.readouterr().err.splitlines()
    assert lines[-1].startswith(f"stickslip: {path}: with the whole force the simulated tracking")
    assert any(line.startswith("as in the log") for line in lines[:-1])  # the table
    assert lines[-1].endswith("--force exports it anyway")
    assert export(path, tmp_path, "--force") == 0
    assert start_of(tmp_path / "compensator.fmu", "F_c") == PAPER["F_c"]
