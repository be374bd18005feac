"""Measured logs: the published figures of EMPS, and a tribometer's hysteresis."""

from dataclasses import replace
from pathlib import Path

import pytest

from stickslip import cosim
from stickslip.evaluation.tracking import VELOCITY
from stickslip.fmi.files import digest
from stickslip.learned.file import LearnedFile
from stickslip.logs import load_description, read_and_check
from stickslip.logs.excitation import excitation
from stickslip.studies.learn.command import print_estimation
from stickslip.studies.learn.folder import write_learned
from stickslip.studies.learn.log_learning import learn
from stickslip.studies.learn.verdict import verdict_of
from stickslip.trial.candidates import CompensatorComparison, Row
from tests.kept import kept

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[3]
DATA = ROOT.parent / "shared" / "data"
EXAMPLES = ROOT / "examples" / "logs"


def learned(folder, name, example, **asked):
    path = DATA / folder / name
    if not path.exists():
        pytest.skip(f"{path} is not here")
    how = EXAMPLES / example
    name = "-".join([folder, digest(how)[:8], *asked.values()])
    return kept(name, lambda _: learn(path, load_description(how), **asked))


@pytest.fixture(scope="module")
def emps():
    return learned("emps", "DATA_EMPS.mat", "emps.toml", compensator="static")


@pytest.fixture(scope="module")
def of_lugre():
    return learned("emps", "DATA_EMPS.mat", "emps.toml", law="lugre", compensator="lugre")


@pytest.mark.thorough
def test_the_law_chosen_for_emps_predicts_as_well_as_friction_without_presliding(emps):
    found = emps.estimation
    force = {one.candidate.title: one.force for one in found.choice.predictions}
    static = min(force["Coulomb-Stribeck with F_s = F_c"], force["Coulomb-Stribeck"])
    assert found.choice.chosen.force <= 1.02 * static < force["LuGre"]


@pytest.mark.thorough
def test_lugre_predicts_emps_worse_than_coulomb_and_viscous_friction(of_lugre, capsys):
    own = of_lugre.estimation.held_out.predictions[0].moving
    assert own.law > 1.3 * own.regression
    assert 'give law="auto"' in of_lugre.refusal
    assert not of_lugre.writes()
    known = of_lugre.estimation.known
    assert all(one.identifiability != "identifiable" for one in known.values())
    for name in ("F_s", "v_s", "sigma_0", "sigma_1"):
        assert known[name].identifiability == "not identifiable"
    print_estimation(of_lugre.estimation)
    said = capsys.readouterr().out
    assert said.count("not identifiable in this experiment") == 4
    assert "stickslip plan --show sigma_0" in said


@pytest.mark.thorough
def test_emps_gives_the_published_parameters(emps):
    """Janot, Gautier, Brunot (2019): M, F_v, F_c and the offset, by least squares."""
    assert emps.estimation.figures.force_unfiltered < 0.0408
    assert emps.estimation.figures.position <= 0.000138
    known = emps.estimation.known
    assert known["m"].value == pytest.approx(95.1089, rel=0.01)
    assert known["b"].value == pytest.approx(203.5034, rel=0.02)
    assert known["F_c"].value == pytest.approx(20.3935, rel=0.01)
    assert emps.estimation.parameters["F_0"] == pytest.approx(-3.1648, rel=0.01)
    assert {known[name].identifiability for name in ("F_s", "v_s")} == {"not identifiable"}


def test_a_straight_line_gives_about_the_published_mass_and_friction_of_emps():
    path = DATA / "emps" / "DATA_EMPS.mat"
    if not path.exists():
        pytest.skip(f"{path} is not here")
    reading, findings = read_and_check(path, load_description(EXAMPLES / "emps.toml"))
    assert {one.severity for one in findings} <= {"note", "warning"}
    shown = excitation(reading.recording)
    assert shown.mass == pytest.approx(95.1089, rel=0.02)
    assert shown.coulomb == pytest.approx(20.3935, rel=0.05)


@pytest.mark.thorough
def test_the_error_of_emps_is_that_of_its_loop_and_velocity_feedforward_removes_it(emps):
    """A position loop without velocity feedforward lags by v / K_x, 0.8 mm at 0.128 m/s."""
    verdict = verdict_of(emps)
    assert "friction is not the problem: 97.7 % of the position error" in verdict.headline
    assert not verdict.files
    assert verdict.loop.measured == pytest.approx(verdict.loop.without, rel=0.01)
    assert verdict.loop.remedy == VELOCITY
    assert verdict.loop.remedied < 0.1 * verdict.loop.frictionless


@pytest.mark.thorough
@pytest.mark.usefixtures("without_pictures")
def test_a_forced_compensator_has_the_whole_force_in_all_files(of_lugre, tmp_path):
    benefit = replace(of_lugre.trial.benefit, share=0.8)
    rows = (of_lugre.trial.compared.rows[0], Row("lugre", 2, 1.2, benefit))
    trial = replace(of_lugre.trial, benefit=benefit, compared=CompensatorComparison(rows, "lugre"))
    write_learned(replace(of_lugre, trial=trial), tmp_path, force=True)
    whole = of_lugre.estimation.compensator
    assert LearnedFile(tmp_path / "learned.json").compensator == pytest.approx(whole)
    start = cosim.Fmu(tmp_path / "compensator.fmu").variables["F_c"].start
    assert start == pytest.approx(whole["F_c"])


@pytest.mark.usefixtures("without_pictures")
@pytest.mark.thorough
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
