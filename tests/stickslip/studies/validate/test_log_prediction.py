"""Another log against a learned drive: a simulation without stickslip is the other log."""

import json
import re
from pathlib import Path

import pandas as pd
import pytest

from stickslip.cli import main
from stickslip.errors import UsageError
from stickslip.learned.file import LearnedFile
from stickslip.logs import Column, Description
from stickslip.studies.validate.log_validation import read_log, validate_log
from stickslip.studies.validate.log_verdict import material, verdict
from stickslip.studies.validate.page.log import draw_prediction
from tests.same_results import simulate_log

pytestmark = pytest.mark.slow

TRUTH = {
    "F_s": 9.0, "F_c": 6.0, "v_s": 5e-4, "sigma_0": 4e5, "sigma_1": 4.5e3, "m": 5.5, "b": 7.0,
}  # fmt: skip
GAINS = {"K_p": 1681.0, "K_i": 137167.0, "tau_f": 5e-4}
GIVEN = ["--column", "force=F_motor", "--encoder-step", "4e-7"]
LOOP = ["--controller", "PI", "--gain", *(f"{name}={value}" for name, value in GAINS.items())]


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("other") / "other.csv"
    simulate_log(path, seed=3)
    return path


@pytest.fixture
def learned(tmp_path):
    """Return a function that writes a learned.json with factors on the truth."""

    def write(factors=None, **entries) -> Path:
        values = {name: value * (factors or {}).get(name, 1.0) for name, value in TRUTH.items()}
        parameters = {
            name: {"value": value, "standard_error": 1e-3 * value} for name, value in values.items()
        }
        path = tmp_path / "learned.json"
        document = {"parameters": parameters, "delta": {"value": 2.0}, **entries}
        path.write_text(json.dumps(document))
        return path

    return write


def described(gains=None) -> Description:
    columns = {"force": Column(name="F_motor")}
    kind = "PI" if gains else "none"
    return Description(columns=columns, encoder_step=4e-7, controller=kind, gains=gains or {})


def predicted(path, log, gains=None):
    file = LearnedFile(path)
    return validate_log(read_log(log, described(gains), file), file), file.drive


def test_the_right_drive_holds_and_noise_explains_every_signal(learned, log):
    found, values = predicted(learned(), log, GAINS)
    assert set(found.signals) == {"force", "position", "velocity", "closed_loop_force"}
    assert all(0.3 < one.ratio < 2.0 for one in found.signals.values())
    assert found.signals["position"].error < 4e-7  # the encoder's step
    assert not list(material(found, values))
    assert verdict(found, values)[0].startswith("the learned drive holds for this log")
    lines = draw_prediction(found).axes[0].get_lines()
    assert {"measured", "predicted"} <= {line.get_label() for line in lines}


@pytest.mark.parametrize("gains", [None, GAINS])
def test_what_differs_is_named_with_an_interval_that_contains_it(learned, log, gains):
    friction = dict.fromkeys(("F_s", "F_c", "sigma_0", "sigma_1"), 1.1)
    found, values = predicted(learned({"m": 0.9, **friction}), log, gains)
    changed = dict(material(found, values))
    assert set(changed) == {"m", "friction"}
    assert changed["m"].low < 5.5 - 0.9 * 5.5 < changed["m"].high
    assert changed["friction"].low < 1.0 / 1.1 - 1.0 < changed["friction"].high
    first, *reasons = verdict(found, values)
    assert first.startswith("the drive of this log differs from the learned one")
    assert any(reason.startswith("friction: -") and "%" in reason for reason in reasons)
    share = 100.0 * changed["m"].value / values["m"]
    assert any(reason.startswith(f"inertia: {share:+.3g} % ") for reason in reasons)
    assert ("position" in found.signals) == (gains is not None)


def test_wrong_gains_are_named_and_the_force_is_not_blamed(learned, log):
    found, values = predicted(learned(), log, {**GAINS, "K_p": 900.0})
    first, *reasons = verdict(found, values)
    assert first.startswith("the learned drive explains the force of this log, but not its loop")
    assert any("its gains are others" in reason for reason in reasons)


def test_a_log_of_another_kind_of_drive_is_refused(learned, log):
    file = LearnedFile(learned(motion="rotary"))
    with pytest.raises(UsageError, match=r"a log of a linear drive, but .* has a rotary one"):
        read_log(log, described(), file)
    table = pd.read_csv(log)
    table.columns = [name.partition(" ")[0] for name in table]
    unstated = log.with_name("unstated.csv")
    table.to_csv(unstated, index=False)
    assert read_log(unstated, described(), file).reading.recording.rotary


def test_the_command_prints_the_verdict_and_writes_tables_and_page(learned, log, tmp_path, capsys):
    out = tmp_path / "out"
    arguments = ["validate", str(learned({"m": 0.9})), "--log", str(log), *GIVEN, *LOOP]
    assert main([*arguments, "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "verdict: the drive of this log differs from the learned one" in printed
    table = pd.read_csv(out / "prediction.csv").set_index("signal")
    assert f"{100.0 * table.relative['force']:8.3g} %" in printed
    spans = pd.read_csv(out / "spans.csv")
    assert list(spans.columns) == [*("begin", "end", "force_bias", "force_error", "position_error")]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "The drive of this log differs from the learned one" in page
    shown = re.search('Force, [^<]*</th><td class="word">mN</td><td class="number">([^<]*)', page)
    assert float(shown[1]) == pytest.approx(1e3 * table.error["force"], rel=5e-3)
    assert main(["verify", str(out)]) == 0


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--log LOG --parameters other.json", "expected a learned.json as an argument"),
        ("", "expected --log FILE, or --rig FILE.toml"),
        ("--without LOG", "--without: expected --log with a log of the same drive, compensated"),
    ],
)
def test_words_that_do_not_belong_together_are_refused(words, message, learned, log, capsys):
    more = [str(log) if word == "LOG" else word for word in words.split()]
    assert main(["validate", str(learned()), *more]) != 0
    assert message in capsys.readouterr().err
