"""What was learned is exported, and refused where it is unknown or not robust."""

import json
import re

import numpy as np
import pytest

from stickslip import cosim
from stickslip.catalog.parameters import LUGRE, PAPER, UNITS
from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.evaluation.motions import VALIDATION
from stickslip.learned.deploying import PAGE
from stickslip.learned.file import LearnedFile
from stickslip.learned.writing import loop_document, validation_document
from stickslip.logs import Recording
from stickslip.models.firmware.program import literal
from stickslip.servo.axis import LOOP, Axis, Datasheet
from stickslip.servo.tuned_pi import with_inertia, with_velocity_filter
from stickslip.servo.velocity_filter import FilterSpecification, Observer, design_velocity_filter
from stickslip.servo.velocity_loop import close_velocity_loop, design_velocity_loop
from stickslip.storage.codec import encode
from tests.cosim.single import by_fmpy, exposed

AXIS = Axis(5.557, 6.6135, 1e-4)
LOOPS = {
    "paper": design_velocity_loop(AXIS, LOOP),
    "weak": close_velocity_loop(AXIS, 5e-4, 5e-4, 200.0, 2000.0),
}
LOOPS["filter"] = with_inertia(with_velocity_filter(LOOPS["paper"], Datasheet(), 6.0))
LOOPS["cascade"] = LOOPS["weak"].changed(K_x=40.0, velocity_feedforward=0.3)
SLOW = cosim.Trapezoid(height=5e-4, slope=0.01, plateau=1.0, begin=0.1)
SHORT = cosim.Trapezoid(height=0.02, slope=0.4, plateau=0.1, begin=0.05)
TRIED = {"loop": loop_document(LOOPS["paper"]), "validation": validation_document(SHORT)}


@pytest.fixture
def learned(tmp_path):
    """Write a learned.json with Table 2 and more entries; return its path."""

    def write(**entries):
        parameters = {name: {"value": PAPER[name], "standard_error": None} for name in LUGRE}
        path = tmp_path / "learned.json"
        path.write_text(json.dumps({"parameters": parameters, **entries}))
        return path

    return write


@pytest.fixture
def export(learned, tmp_path, capsys):
    """Export from a learned.json with these entries; return status and what is printed."""

    def run(what: str, *options: str, **entries) -> tuple[int, str, str]:
        arguments = ["--parameters", str(learned(**entries)), "--out", str(tmp_path), *options]
        return main(["export", what, *arguments]), *capsys.readouterr()

    return run


def document(rate: float = 1.5, refusal: str = "", order: int = 1) -> dict:
    """Return a learned.json with the observer of a disturbance rate [N/s^0.5], or [N/s^1.5]."""
    kalman = design_velocity_filter(AXIS, LOOP.T_s, FilterSpecification(4e-7, 0.05, rate, order))
    values = Observer(kalman, 0.75).parameters()
    return {
        "loop": loop_document(LOOPS["paper"]),
        "observer": {
            "refusal": refusal,
            "parameters": {name: {"value": value} for name, value in values.items()},
        },
    }


@pytest.mark.parametrize(("rate", "order", "name"), [(1.5, 1, "L_d"), (300.0, 2, "L_1")])
def test_it_writes_the_gains_in_each_form(export, tmp_path, rate, order, name):
    content = document(rate, order=order)
    gain = repr(content["observer"]["parameters"][name]["value"])
    forms = {"fmu": ["fmu"], "c": ["h", "c"], "st": ["st"], "plcopen": ["xml"]}
    content["written"] = {"files": ["compensator.fmu", "observer.fmu"]}
    row = {"motion": "creep", "figure": "velocity", "without": 1.0, "left": 0.5}
    foreign = "tried in a PI velocity loop, which is not the log's"
    content["verdict"] = {"errors": [row | {"low": 0.4, "high": 0.6}], "doubts": [foreign]}
    for form, names in forms.items():
        status, out, error = export("observer", "--as", form, **content)
        assert (status, error) == (0, "")
        head = (tmp_path / f"observer.{names[0]}").read_text() if form != "fmu" else ""
        end = names[-1]
        for words in (
            f"to be used as a whole: compensator.{end} and observer.{end}",
            f"that what was written leaves, with compensator.{end}:",
            f"tau_f = 0.0005 s, K_p = {LOOPS['paper'].K_p:.5g} N.s/m",
            foreign,
        ):
            assert words in re.sub(r"\n[ *]*", " ", head) or form == "fmu"
        assert out.split() == [str(tmp_path / f"observer.{end}") for end in names]
    assert gain in (tmp_path / "observer.c").read_text()
    assert gain in (tmp_path / "observer.st").read_text()
    assert f'"{literal(float(gain))}"' in (tmp_path / "observer.xml").read_text()


def test_a_loop_that_is_not_robust_with_it_is_refused(export, tmp_path):
    status, _, error = export("observer", **document(rate=50.0))
    assert status == 1
    assert "with the observer the loop has a peak sensitivity of 2.5" in error
    assert not (tmp_path / "observer.fmu").exists()
    status, _, error = export("observer", "--force", "--as", "c", **document(rate=50.0))
    assert status == 0
    assert "peak sensitivity" in error


def test_what_learn_refused_or_never_designed_is_refused_in_a_line(export):
    status, _, error = export("observer", **document(refusal="creep is 1.2 times worse"))
    assert status == 1
    assert "learn does not recommend the observer: creep is 1.2 times worse; --force" in error
    status, _, error = export("observer", observer={"refusal": "the mass is not known"})
    assert status == 1
    assert "contains no disturbance observer: the mass is not known" in error
    broken = document()
    del broken["observer"]["parameters"]["tau_i"]
    assert "observer: 'tau_i' is missing" in export("observer", **broken)[2]
    broken["observer"]["parameters"]["tau_i"] = {"value": -1.0}
    assert "observer: dob: tau_i = -1 s is outside 0 .. 1 s" in export("observer", **broken)[2]
    broken["observer"]["model"] = "drive"
    assert "observer: model 'drive' is not a compensator" in export("observer", **broken)[2]
    broken["observer"]["model"] = "absent"
    assert "observer: " in export("observer", **broken)[2]


def test_what_learn_wrote_is_deployed_behind_one_call_and_nothing_else_is(export, tmp_path):
    entries = {**document(), "motion": "rotary", "position_force": HELD}
    assert "nothing to deploy: it does not state" in export("deploy", **entries)[2]
    assert not (tmp_path / "steps.html").exists()
    entries["written"] = {"files": ["position_force.fmu", "observer.fmu"]}
    status, out, error = export("deploy", **entries)
    assert (status, error) == (0, "")
    names = {line.rpartition("/")[2] for line in out.split()}
    blocks = {f"{name}.{end}" for name in ("position_force", "observer") for end in "ch"}
    assert names == {*blocks, *(f"added_force.{end}" for end in ("c", "h", "st", "xml")), PAGE}
    page = (tmp_path / PAGE).read_text()
    for shown, words in (
        (True, "The zero of x_enc must be that of the log"),
        (True, "reduce the integral"),
        (True, "cc -c added_force.c position_force.c observer.c"),
        (True, "N\xa0m"),
        (False, "F_ff of the compensator"),
        (True, "PLC: one call with <code>reset := TRUE</code>"),
        (False, "it was tried with a limit"),
    ):
        assert (words in page) == shown
    entries["datasheet"] = {"peak_force": {"value": 50.0, "unit": "N.m"}}
    assert export("deploy", **entries)[0] == 0
    assert "it was tried with a limit of 50 N\xa0m" in (tmp_path / "steps.html").read_text()


HELD = {
    "F_0": {"value": 3.0, "unit": "N.m"},
    "g_s": {"value": -2.0, "unit": "N.m"},
    "cogging_c[2]": {"value": 0.7, "unit": "N.m"},
    "pitch": {"value": 0.3, "unit": "rad"},
}


def test_a_force_of_position_is_exported_and_is_that_of_a_closed_form(export, tmp_path):
    entries = {"motion": "rotary", "position_force": HELD}
    entries["written"] = {"files": ["position_force.fmu"]}
    for form in ("fmu", "c", "st"):
        status, out, error = export("position_force", "--as", form, **entries)
        assert (status, error) == (0, "")
        assert str(tmp_path / f"position_force.{form}") in out.split()
    x = np.linspace(-2.0, 2.0, 41)
    system = exposed(tmp_path / "position_force.fmu", name="block")
    with system.prepare(step=5e-4, stop=0.02) as simulation:
        found = simulation.run(inputs={"x": x, "F_in": 5.0})["block.F"][1:]
    expected = 8.0 - 2.0 * np.sin(x) + 0.7 * np.cos(4.0 * np.pi * x / 0.3)
    np.testing.assert_allclose(found, expected[:-1], rtol=1e-12)
    recording = Recording(5e-4 * np.arange(41), x, motion="rotary")
    known = LearnedFile(tmp_path / "learned.json").with_position_force(recording).known_force
    np.testing.assert_allclose(known, expected - 8.0, atol=1e-12)


def test_a_model_of_a_robot_says_that_it_has_no_force_of_position(export):
    cogging = {"cogging_c[2]": {"value": 0.7}, "pitch": {"value": 0.3}}
    status, _, error = export("drive", **document(), position_force=cogging)
    assert status == 0, error
    assert "of the force of position, cogging_c[2] are left out" in error


def test_a_force_of_position_that_is_not_sound_is_refused_in_a_line(export):
    assert "contains no force of position" in export("position_force")[2]
    found = {"motion": "rotary", "position_force": HELD, "refusal": "the mass is not plausible"}
    refusal = export("position_force", **found)[2]
    assert "the mass is not plausible; --force exports it anyway" in refusal
    wrong = {"pitch": {"value": -1.0}}
    assert "pitch = -1 m is outside" in export("position_force", position_force=wrong)[2]
    assert (
        "has no parameter h_1"
        in export("position_force", position_force={"h_1": wrong["pitch"]})[2]
    )
    metres = {"motion": "rotary", "position_force": {"g_s": {"value": 1.0, "unit": "N"}}}
    assert "position_force: g_s is in 'N'; expected N.m" in export("position_force", **metres)[2]


@pytest.mark.parametrize("name", LOOPS)
def test_a_loop_comes_back_as_it_was(learned, name):
    loop = LOOPS[name]
    again = LearnedFile(learned(loop=loop_document(loop))).loop
    assert again.axis == loop.axis
    assert again.K_x == loop.K_x
    assert again.velocity_filter == loop.velocity_filter
    for matrix in ("A", "B", "C", "D"):
        np.testing.assert_array_equal(getattr(again.nominal, matrix), getattr(loop.nominal, matrix))
    np.testing.assert_array_equal(again.acceleration.B, loop.acceleration.B)


def test_what_an_older_file_lacks_has_a_default_and_the_rest_comes_back(learned):
    file = LearnedFile(learned())
    assert (file.loop, file.drive_errors) == (None, {})
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


@pytest.mark.slow
def test_export_reduces_a_force_that_would_hurt_a_drive_of_the_file(export, tmp_path):
    half = {
        n: {"value": (0.5 if UNITS[n] != "m/s" else 1.0) * PAPER[n], "unit": UNITS[n]}
        for n in LUGRE
    }
    drive = {"drive": "half the friction", "law": "lugre", "parameters": half, "level": 0.5}
    entries = {**TRIED, "family": [drive]}
    status, _, error = export("compensator", **entries)
    [line] = error.splitlines()
    share = float(line.split("warning: ")[1].split(" of the force is exported")[0])
    assert status == 0
    assert "with 0.5 times the friction" in line
    assert 0.5 <= share < 1.0
    fmu = tmp_path / "compensator.fmu"
    assert start_of(fmu, "F_c") == pytest.approx(share * PAPER["F_c"], rel=1e-12)
    assert start_of(fmu, "v_s") == PAPER["v_s"]
    status, _, error = export("compensator", "--force", **entries)
    assert (status, "the whole force is exported" in error) == (0, True)
    assert start_of(fmu, "F_c") == PAPER["F_c"]


@pytest.mark.slow
@pytest.mark.parametrize("entries", [TRIED, {}])
def test_force_exports_the_whole_force_whatever_share_the_file_has(export, tmp_path, entries):
    entries |= {"share": {"value": 0.6}, "tracking_error": [{"ratio": 0.5}]}
    for options, share in (((), 0.6), (("--force",), 1.0)):
        status, _, error = export("compensator", *options, **entries)
        assert status == 0
        assert start_of(tmp_path / "compensator.fmu", "F_c") == pytest.approx(share * PAPER["F_c"])
        told = "the whole force is exported, as --force asks for, not 0.6 of it"
        assert (told in error) == bool(options)


@pytest.mark.slow
def test_export_of_what_was_never_tried_is_refused_and_forced(export, tmp_path):
    fmu = tmp_path / "compensator.fmu"
    refusal = "it was not tried, because no velocity loop can be closed"
    for entries, why in (({}, "neither a loop"), ({"refusal": refusal}, refusal)):
        status, _, error = export("compensator", **entries)
        assert (status, why in error, fmu.exists()) == (1, True, False)
        status, _, error = export("compensator", "--force", **entries)
        assert (status, why in error) == (0, True)
        fmu.unlink()
    status, _, error = export("compensator", tracking_error=[{"ratio": 0.5}])
    (line,) = error.splitlines()
    assert status == 0
    assert "the force is that of the velocity command" in line


@pytest.mark.slow
def test_export_refuses_what_makes_the_loop_worse_unless_forced(export, tmp_path):
    """A log that also supports a drive with a hundredth of the friction."""
    friction = {**{name: PAPER[name] for name in LUGRE}, "F_c": 0.06, "F_s": 0.09}
    slippery = {name: {"value": value, "unit": UNITS[name]} for name, value in friction.items()}
    drive = {"drive": "hardly any friction", "law": "lugre", "parameters": slippery}
    entries = {**TRIED, "family": [drive]}
    status, _, error = export("compensator", **entries)
    *lines, last = error.splitlines()
    assert status == 1
    assert re.match(r"stickslip: \S*json: with the whole force the simulated tracking", last)
    assert any(line.startswith("as in the log") for line in lines)  # the table
    assert last.endswith("--force exports it anyway")
    assert export("compensator", "--force", **entries)[0] == 0
    assert start_of(tmp_path / "compensator.fmu", "F_c") == PAPER["F_c"]


STEP, STOP = 5e-4, 1.0


@pytest.mark.slow
@pytest.mark.parametrize("fmi", [2, 3])
def test_the_tuned_loop_in_fmpy(results, fmi, tmp_path, capsys):
    package = results / "loop.ssp"
    chosen = ["--outputs", "drive.*", "--parameters", "compensator.*", "--set", "drive.F_c=5"]
    arguments = ["export", package, "--fmi", fmi, "--out", tmp_path / "whole.fmu", *chosen]
    assert main([str(a) for a in arguments]) == 0
    path = tmp_path / "whole.fmu"
    assert capsys.readouterr().out.strip() == str(path)

    system, _ = cosim.read_ssp(package)
    system.set("drive.F_c", 5.0)
    with system.prepare(step=STEP, stop=STOP) as simulation:
        v_cmd = 0.01 * np.sin(2 * np.pi * simulation.time)
        ours = simulation.run({"compensator.sigma_0": 1e5}, {"v_cmd": v_cmd})
    how = {"step_size": STEP, "start_values": {"compensator.sigma_0": 1e5}}
    theirs = by_fmpy(path, STEP, STOP, inputs=[ours.time, ("v_cmd", "f8", v_cmd)], **how)
    shown = theirs.dtype.names[1:]
    assert shown
    assert all(name.startswith("drive.") for name in shown)
    for name in shown:
        np.testing.assert_array_equal(theirs[name], ours[name], err_msg=name)
