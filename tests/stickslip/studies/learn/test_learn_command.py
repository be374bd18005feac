"""``stickslip learn``: from a log to a folder of results."""

import io
import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import stickslip as ss
from stickslip import ga
from stickslip.app.workbench import LOGS, Workbench
from stickslip.cli import main
from stickslip.commandline.progress import TerminalProgress
from stickslip.identification.criteria.motion import Scale
from stickslip.output import steps
from stickslip.studies.learn.folder import FILES
from tests.stickslip.conftest import ASKED

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("brief")]


def test_the_folder_is_whole_and_keeps_no_checkpoint(learned_log):
    folder = learned_log.folder
    document = json.loads((folder / "learned.json").read_text())
    assert main(["verify", str(folder)]) == 0
    parts = {name for name in FILES if name.endswith(".fmu")} - {*document["written"]["files"]}
    absent = {name for name in FILES if f"{Path(name).stem}.fmu" in parts}
    found = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert found == {*FILES, "manifest.json"} - absent
    assert not [name for name in FILES if "checkpoint" in name]


def test_searching_judging_and_trying_tell_how_far_they_are(learned_log):
    steps = learned_log.steps
    compared = steps.index((2, 3))
    assert steps[0] == (0, 6)  # laws
    assert (0, 3) in steps  # starts of a fit, which ends when two lead to the same minimum
    assert steps[compared : compared + 2] == [(2, 3), (3, 3)]
    tried = steps[compared + 2 :]
    assert len(tried) > 50
    assert all(end is None for _, end in tried)  # a count of what was tried, which never falls
    assert all(b[0] - a[0] in (0, 1) for a, b in pairwise(tried))


def test_a_terminal_shows_stages_and_the_remaining_time(monkeypatch):
    for terminal in (False, True):
        stream = io.StringIO()
        monkeypatch.setattr(stream, "isatty", lambda shown=terminal: shown, raising=False)
        monkeypatch.setattr("sys.stderr", stream)
        with TerminalProgress() as progress:
            progress.stage("fitting")
            for _ in steps("abcd"):
                pass
        assert ("fitting ...\n" in stream.getvalue()) is terminal
        assert ("0/4 [00:00<" in stream.getvalue()) is terminal


def test_the_bar_of_a_search_shows_its_cost_and_the_remaining_time(monkeypatch):
    stream = io.StringIO()
    monkeypatch.setattr(stream, "isatty", lambda: True, raising=False)
    monkeypatch.setattr("sys.stderr", stream)
    genes = [ga.Gene("F_c", 0.1, 10.0, 1.0), ga.Gene("v_s", 1e-4, 1e-1, 2e-3)]
    with TerminalProgress() as progress:
        progress.stage("searching")
        ga.learn(
            ga.GeneticAlgorithm(genes, seed=1, limits=ga.Limits(generations=6)),
            lambda values: float(1e-6 + 1e-9 * np.log(values[0] / 3.0) ** 2),
            on_generation=lambda search: progress.generation(search, Scale(force=100.0)),
        )
    shown = stream.getvalue()
    assert "6/6 [00:0" in shown
    assert "best cost 1e-10" in shown  # 1e-6 of that unit squared


@pytest.mark.thorough
def test_with_other_workers_no_byte_differs(log, learned_log, tmp_path):
    out, folder = tmp_path / "out", learned_log.folder
    assert main(["learn", "--log", str(log), *ASKED, "--workers", "3", "--out", str(out)]) == 0
    for whole in filter(Path.is_file, folder.rglob("*")):
        assert (out / whole.relative_to(folder)).read_bytes() == whole.read_bytes(), whole.name


def test_it_prints_and_writes_whether_compensation_helps(learned_log):
    """The median over the drives of a level grows in no motion by more than 2 %."""
    folder, out, error = learned_log.folder, learned_log.said, learned_log.warned
    document = json.loads((folder / "learned.json").read_text())
    predicted = document["predicted_error"]
    assert {row["friction"] for row in predicted if row["decides"]} == {0.7, 1.0, 1.3}
    assert {row["friction"] for row in predicted if not row["decides"]} == {0.5, 2.0}
    assert all(row["ratio"] <= 1.02 for row in predicted if row["decides"])
    assert all(row["low"] <= row["ratio"] <= row["high"] for row in predicted)
    chosen = document["compared"]["chosen"]
    table = out.split(f"RMS error of velocity with {chosen}")[1].splitlines()
    [row] = [one for one in predicted if (one["friction"], one["motion"]) == (2.0, "micro-steps")]
    assert f" {row['ratio']:.3g} " in next(line for line in table if line.startswith("2 times"))
    assert "its controller is not known; --controller and --gain give it" in error
    report = (folder / "report.html").read_text(encoding="utf-8")
    opening = report.index("Tracking without and with the compensator")
    assert report.index("<h1>") < opening < report.index("Learned parameters")
    assert document["tracking"]["measured"] is None  # no command was logged
    simulated = document["tracking"]["simulated"]
    errors = [simulated[f"{how} compensator"]["velocity_rms"] for how in ("with", "without")]
    assert errors[0] < 0.85 * errors[1]  # of its feedforward alone
    assert "tracking error on a trapezoid at the log's speed" in out
    assert "Whether compensation helps" in report
    has_observer = "observer" in document["compensation"]
    assert (folder / "observer.fmu").exists() == has_observer
    assert ("export observer" in report) == has_observer


def test_no_compensator_of_a_mass_that_hardly_any_drive_has(log, tmp_path, capsys, monkeypatch):
    """The check before learning sees only clear masses; here it sees none."""
    arguments = ["learn", "--log", str(log), "--scale", "force=5e-5", "--criterion", "inverse"]
    arguments += ["--law", "lugre", "--out", str(tmp_path)]
    assert main(arguments) == 1
    assert "kg, less than 0.001 kg" in capsys.readouterr().err
    module = "stickslip.studies.learn.log_learning"
    monkeypatch.setattr(f"{module}.try_compensator", lambda *_, **__: None)
    monkeypatch.setattr("stickslip.logs.checked.check_units", lambda _: ())
    assert main(arguments) == 0
    assert "compensator.fmu is not written: error: the mass" in capsys.readouterr().out
    assert (tmp_path / "learned.json").exists()
    assert not (tmp_path / "compensator.fmu").exists()
    assert main([*arguments, "--confirm", "mass"]) == 0
    assert (tmp_path / "compensator.fmu").exists()


def test_a_compensator_that_cannot_be_learned_is_refused_before_learning(log, capsys):
    refused = {
        ("auto", "--friction-range", "1.2", "1.5"): "--friction-range: expected the least and the",
        ("dahl", "--law", "lugre"): "'dahl': --law is lugre; there are static, lugre, ekbf",
        ("lffc",): "it is trained on the drive; 'stickslip arena --drive learned.json'",
        ("ekbf+static",): "both in this order, such as static+ekbf",
        ("ekbf", "--without", "motor_force"): "a signal that the controller lacks: motor_force",
    }
    for name, message in refused.items():
        assert main(["learn", "--log", str(log), "--compensator", *name]) == 1
        assert message in capsys.readouterr().err


def test_a_description_is_given_by_its_file(tmp_path):
    with pytest.raises(ss.Fault, match=r"nowhere\.toml"):
        ss.learn(tmp_path / "axis.csv", tmp_path / "nowhere.toml")


def test_compressed_logs_are_offered(tmp_path):
    for name in ("axis.csv.gz", "axis.gz", "page.html.gz"):
        (tmp_path / name).touch()
    assert list(Workbench(tmp_path).files(LOGS).values()) == ["axis.csv.gz"]
