"""Measured logs: the published figures of EMPS, and a tribometer's hysteresis."""

from dataclasses import replace
from pathlib import Path

import pytest

from stickslip import cosim
from stickslip.cli import main
from stickslip.learned.file import LearnedFile
from stickslip.logs import Finding, load_description
from stickslip.studies.learn.command import print_estimation
from stickslip.studies.learn.folder import write_learned
from stickslip.studies.learn.log_learning import learn
from stickslip.trial.candidates import CompensatorComparison, Row
from stickslip.trial.guards import Benefit

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[3]
DATA = ROOT.parent / "shared" / "data"
EXAMPLES = ROOT / "examples" / "logs"


def learned(folder, name, example, law="auto"):
    path = DATA / folder / name
    if not path.exists():
        pytest.skip(f"{path} is not here")
    return learn(path, load_description(EXAMPLES / example), law=law)


@pytest.fixture(scope="module")
def emps():
    return learned("emps", "DATA_EMPS.mat", "emps.toml", law="lugre")


@pytest.fixture(scope="module")
def sound(emps):
    """Return the same as if LuGre predicted what it was not fitted to."""
    return replace(emps, estimation=replace(emps.estimation, faults=()))


def only(sound, benefit):
    """Return what was learned where feedforward of the law was asked for, and does this."""
    rows = (sound.trial.compared.rows[0], Row("lugre", 2, 1.2, benefit))
    compared = CompensatorComparison(rows, "lugre")
    return replace(sound, trial=replace(sound.trial, benefit=benefit, compared=compared))


def test_the_law_chosen_for_emps_predicts_as_well_as_friction_without_presliding():
    found = learned("emps", "DATA_EMPS.mat", "emps.toml").estimation
    force = {one.candidate.title: one.force for one in found.choice.predictions}
    static = min(force["Coulomb-viscous"], force["Coulomb-Stribeck"])
    assert found.choice.chosen.force <= 1.02 * static < force["LuGre"]
    assert found.known["F_c"].value == pytest.approx(20.3935, rel=0.01)
    assert found.known["m"].value == pytest.approx(95.1089, rel=0.01)


def test_lugre_predicts_emps_worse_than_coulomb_and_viscous_friction(emps):
    own = emps.estimation.held_out.predictions[0].moving
    assert own.law > 1.3 * own.regression
    assert 'give law="auto"' in emps.refusal
    assert not emps.writes()
    assert all(one.identifiability != "identifiable" for one in emps.estimation.known.values())


def test_emps_gives_the_published_parameters_and_is_explained_better(emps):
    """Janot, Gautier, Brunot (2019): M, F_v, F_c and the offset, by least squares."""
    assert emps.estimation.figures.force_unfiltered < 0.0408
    assert emps.estimation.figures.position <= 0.000138
    known = emps.estimation.known
    assert known["m"].value == pytest.approx(95.1089, rel=0.01)
    assert known["b"].value == pytest.approx(203.5034, rel=0.02)
    assert known["F_c"].value == pytest.approx(20.3935, rel=0.01)
    assert pytest.approx(-3.1648, rel=0.01) == emps.estimation.F_0


def test_emps_shows_no_presliding_and_says_so(emps, capsys):
    for name in ("F_s", "v_s", "sigma_0", "sigma_1"):
        assert emps.estimation.known[name].identifiability == "not identifiable"
    print_estimation(emps.estimation)
    said = capsys.readouterr().out
    assert said.count("not identifiable in this experiment") == 4
    assert "stickslip plan --show sigma_0" in said


@pytest.mark.usefixtures("without_pictures")
def test_what_was_learned_is_written_and_read(sound, tmp_path):
    sound = only(sound, sound.trial.benefit)
    write_learned(sound, tmp_path)
    assert LearnedFile(tmp_path / "learned.json").compensator == pytest.approx(sound.compensator)
    assert sum("not identifiable in this experiment" in warning for warning in sound.warnings) == 4
    start = cosim.Fmu(tmp_path / "compensator.fmu").variables["F_c"].start
    assert start == pytest.approx(sound.compensator["F_c"])
    assert "DATA_EMPS.mat" in (tmp_path / "report.html").read_text(encoding="utf-8")


@pytest.mark.usefixtures("without_pictures")
def test_a_compensator_that_does_harm_is_not_written(sound, tmp_path):
    rows = sound.trial.benefit.rows
    rows = tuple(replace(row, compensated=1.03 * row.without) for row in rows)
    harmful = only(sound, Benefit(1.0, rows, rows, variant=sound.trial.benefit.variant))
    assert "1.03 times that without the compensator" in harmful.refusal
    write_learned(only(sound, sound.trial.benefit), tmp_path)
    assert (tmp_path / "compensator.fmu").exists()
    write_learned(harmful, tmp_path)
    assert not (tmp_path / "compensator.fmu").exists()
    write_learned(harmful, tmp_path, force=True)
    assert (tmp_path / "compensator.fmu").exists()


@pytest.mark.usefixtures("without_pictures")
def test_a_forced_compensator_has_the_whole_force_in_all_files(emps, tmp_path):
    write_learned(only(emps, replace(emps.trial.benefit, share=0.8)), tmp_path, force=True)
    whole = emps.estimation.compensator
    assert LearnedFile(tmp_path / "learned.json").compensator == pytest.approx(whole)
    start = cosim.Fmu(tmp_path / "compensator.fmu").variables["F_c"].start
    assert start == pytest.approx(whole["F_c"])


@pytest.mark.parametrize(("spoils", "written"), [("values", False), ("intervals", True)])
@pytest.mark.usefixtures("without_pictures")
def test_a_compensator_of_wrong_values_is_not_written(emps, tmp_path, spoils, written):
    fault = Finding("warning", "rows are lost", "2 %", "log without gaps", spoils=spoils)
    spoiled = replace(emps, estimation=replace(emps.estimation, faults=(fault,)))
    spoiled = only(spoiled, emps.trial.benefit)
    assert spoiled.refusal == ("" if written else "rows are lost: 2 %; log without gaps")
    write_learned(spoiled, tmp_path)
    assert (tmp_path / "compensator.fmu").exists() == written
    parameters, out = str(tmp_path / "learned.json"), str(tmp_path / "out")
    export = ["export", "compensator", "--parameters", parameters, "--out", out]
    assert main(export) == (0 if written else 1)
    assert main([*export, "--force"]) == 0


@pytest.mark.usefixtures("without_pictures")
def test_the_hysteresis_of_a_tribometer_and_nothing_untried(tmp_path):
    found = learned("tribometer", "test_data_2.txt", "tribometer.toml")
    estimation = found.estimation
    assert estimation.criterion == "inverse model"
    assert estimation.figures.force < 0.2
    assert estimation.known["sigma_0"].identifiability != "not identifiable"
    assert "sign was turned" in estimation.remarks[0]
    assert "it was not tried" in found.refusal
    assert not write_learned(found, tmp_path).files
    assert write_learned(found, tmp_path, force=True).files == ("compensator.fmu",)
