"""What learn says of files is what is in its folder, whatever was refused, forced or asked for."""

import hashlib
import json
import re
import shlex
import zipfile
from dataclasses import replace
from html import unescape
from pathlib import Path
from types import SimpleNamespace

import pytest
from fmpy import read_model_description

from stickslip.cli import main
from stickslip.cosim import Fmu
from stickslip.identification.fitting.identifiability import NOT_IDENTIFIABLE
from stickslip.identification.sliding.friction_curve import Interval
from stickslip.identification.sliding.position_force import PositionForce
from stickslip.learned.deploying import deployed_blocks
from stickslip.learned.file import LearnedFile
from stickslip.learned.provenance import provenance
from stickslip.logs import Finding
from stickslip.models.firmware import write_compensator
from stickslip.presentation.quantity import number
from stickslip.servo.axis import ControlError
from stickslip.studies.learn.document import log_document
from stickslip.studies.learn.folder import write_learned
from stickslip.studies.learn.verdict import LoopShare, _headline, lines, verdict_of
from stickslip.trial.benefit import Benefit, Variant
from stickslip.trial.candidates import Row
from tests.kept import further

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("without_pictures")]

NAME = re.compile(r"\b\w[\w.-]*\.(?:fmu|json|csv|html|png|svg|ssp)\b")
FMUS = {"compensator.fmu", "observer.fmu"}


@pytest.fixture(scope="module")
def sound(learned_log):
    learned = learned_log.learned
    assert learned.choice == "feedforward + observer"
    assert not learned.refusal
    return learned


def leaving(ratio, benefit, share=1.0):
    rows = tuple(replace(row, compensated=ratio * row.without) for row in benefit.rows)
    return Benefit(share, rows, rows, benefit.unit, benefit.variant)


def test_an_observer_leaves_a_weight_to_the_loop_unless_a_block_holds_it(sound):
    """The drives of the trial have none, and the loop holds it at rest."""
    estimation, F_c = sound.estimation, sound.friction["F_c"]

    def left(F_0, held=None):
        known = replace(estimation, parameters={**estimation.parameters, "F_0": F_0})
        learned = replace(sound, estimation=replace(known, position_force=held))
        entries = log_document(learned)["observer"]["parameters"]
        return entries["F_0"]["value"] if "F_0" in entries else None

    assert left(0.7 * F_c) == 0.7 * F_c
    assert left(0.05 * F_c) is None  # of friction that differs by direction
    block = PositionForce({"F_0": Interval(0.7 * F_c, *3 * [0.0])}, 0.0)
    assert left(0.7 * F_c, block) is None


def untried(sound, asked="auto"):
    loops = ControlError("the mass is not known")
    return replace(sound, loops=loops, trial=None, tracking=None, asked=asked)


def only(sound, row, asked="auto"):
    """Return what was learned where nothing but one compensator was tried beside none."""
    compared = replace(sound.trial.compared, rows=(sound.trial.compared.rows[0], row), asked=asked)
    benefit = row.benefit if row.designed is None else leaving(0.5, sound.trial.benefit)
    return replace(
        sound, trial=replace(sound.trial, benefit=benefit, compared=compared), asked=asked
    )


def feedforward(sound, share):
    """Return the row of feedforward of the law, at a share of its force."""
    return Row("law", 2, 1.2, leaving(0.5, sound.trial.benefit, share))


def harmful(sound, asked="auto"):
    row = feedforward(sound, 1.0)
    return only(sound, replace(row, benefit=leaving(1.5, row.benefit)), asked)


def observer(sound):
    chosen = sound.trial.compared.chosen
    variant = Variant("observer", chosen.benefit.variant.chain[-1:])
    return only(sound, replace(chosen, benefit=replace(chosen.benefit, variant=variant)))


def doubtful(sound):
    fault = Finding("warning", "rows are lost", "2 %", "log without gaps", spoils="values")
    return replace(sound, estimation=replace(sound.estimation, faults=(fault,)))


FEEDFORWARD, OBSERVER = {"compensator.fmu"}, {"observer.fmu"}
KINDS = {
    "sound": (lambda sound: sound, FMUS, FMUS),
    "share": (lambda sound: only(sound, feedforward(sound, 0.6)), FEEDFORWARD, FEEDFORWARD),
    "nothing": (harmful, set(), FEEDFORWARD),
    "harmful": (lambda sound: harmful(sound, "law"), set(), FEEDFORWARD),
    "observer": (observer, OBSERVER, OBSERVER),
    "doubtful": (doubtful, set(), FMUS),
    "untried": (untried, set(), FEEDFORWARD),
    "untried observer": (lambda sound: untried(sound, "ekbf"), set(), set()),
}
"""What was learned, and the FMUs in the folder, without and with --force."""


def lines_of(page):
    """Return the text of a page, a line for each element, and the commands in it."""
    body = page.split("<main>")[1].split("</main>")[0]
    blocks = "\n".join(re.findall("<pre><code>(.*?)</code></pre>", body, re.DOTALL))
    commands = re.findall(r"^stickslip .*", re.sub("<[^>]*>", "", blocks), re.MULTILINE)
    return re.sub("<[^>]*>", "\n", body), [unescape(one) for one in commands]


def check_names(text, files):
    """Compare the files that sentences name with those of the folder."""
    for sentence in text.splitlines():
        if "stickslip plan" in sentence:
            continue  # a command that writes another file
        for name in set(NAME.findall(sentence)) - {"log.csv"}:
            left_out = re.search(rf"\b{name}( and [\w.]+)? (is|are) not written", sentence)
            assert (name in files) == (left_out is None), sentence


@pytest.mark.parametrize(
    ("kind", "force"),
    [
        *((kind, False) for kind in KINDS),
        *((kind, True) for kind in ("share", "doubtful")),
        *further(*((kind, True) for kind in KINDS if kind not in ("share", "doubtful"))),
    ],
)
def test_each_sentence_that_names_a_file_is_true(
    kind, force, sound, log, tmp_path, capsys, monkeypatch
):
    (make, *written), out = KINDS[kind], tmp_path / "out"
    learned = make(sound)
    monkeypatch.setattr("stickslip.studies.learn.log_learning.learn", lambda *_, **__: learned)
    arguments = ["learn", str(log), "--out", str(out), *(["--force"] if force else [])]
    assert main(arguments) == 0
    printed, error = capsys.readouterr()
    assert main([*arguments, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    shown = learned.with_whole_force() if force else learned
    files = {path.name for path in out.rglob("*")}
    assert files & FMUS == written[force]
    check_deployment(out, written[force])
    page, commands = lines_of((out / "report.html").read_text(encoding="utf-8"))
    kept = json.loads((out / "learned.json").read_text())
    for text in (printed, error, page, *strings(document), *strings(kept)):
        check_names(text, files)
    for one in (document, kept):
        assert {*one["written"]["files"]} == files & FMUS
        assert one["written"]["forced"] == force
        assert one["refusal"] == learned.refusal
    for text in (printed, page.replace("\u2019", "'")):
        assert not learned.refusal or learned.refusal in text
    check_verdict(printed, kept["verdict"], files & FMUS, shown)
    if learned.refusal and "compensator.fmu" in files:
        description = read_model_description(out / "compensator.fmu").description
        assert (
            f"Written with --force; learn does not recommend it: {learned.refusal}" in description
        )
    monkeypatch.chdir(out)
    for command in commands:
        words = shlex.split(command)[1:]
        further = ["--out", str(tmp_path)] if words[0] == "export" else []
        assert words[0] == "plan" or main([*words, *further]) == 0


def check_deployment(out, fmus):
    """The code behind one call has the values of the FMUs; the page has the steps of its parts."""
    assert (out / "deploy" / "steps.html").exists() == bool(fmus)
    if not fmus:
        return
    learned = LearnedFile(out / "learned.json")
    blocks = {block.name: block for block in deployed_blocks(learned)}
    assert {f"{name}.fmu" for name in blocks} == fmus
    for name, block in blocks.items():
        starts = {v.name: v.start for v in Fmu(out / f"{name}.fmu").variables.values()}
        own = {v.name: v.start for v in block.variables if v.role == "parameter"}
        assert own == {parameter: starts[parameter] for parameter in own}
    page = (out / "deploy" / "steps.html").read_text(encoding="utf-8")
    page = unescape(re.sub("<[^>]*>", "", page))
    table = page[page.index("Inputs; those of") : page.index("Signs and zeros")]
    assert ("Velocity command" in table, "encoder" in table) == (True, "observer.fmu" in fmus)
    assert ("F_ff of the compensator" in page) == ("compensator.fmu" in fmus)
    for check in learned.document["verdict"]["checks"]:
        assert check.split(": ")[-1].lower() in page.lower()
    verdict = learned.document["verdict"]
    assert all(one.lower() in page.lower() for one in verdict["doubts"] if "were tried in" in one)
    for one in verdict["errors"]:
        assert f"{one['motion']}, {one['figure']}: " in page


def check_verdict(printed, verdict, fmus, learned):
    """The card is short, names what is written, and its shares are those of the trial."""
    lines = printed.splitlines()
    assert len(lines) <= 15
    assert lines[0] == f"{verdict['source']}: {verdict['headline']}"
    assert {*verdict["files"]} == fmus
    assert not lines[0].count("worth compensating") or fmus
    for one in verdict["errors"]:
        (own,) = (
            each
            for each in learned.trial.compared.chosen.benefit.motions
            if (each.level, each.rows[0].command) == (1.0, one["motion"])
        )
        assert one["left"] == own.median.compensated
        assert f"{one['motion']} {number(100 * own.median.ratio, 2)} %" in printed


def test_exported_code_states_where_its_numbers_come_from(sound, log, tmp_path):
    write_learned(only(sound, feedforward(sound, 0.6)), tmp_path)
    document = json.loads((tmp_path / "learned.json").read_text())
    assert LearnedFile(tmp_path / "learned.json").drives == sound.trial.drives
    own = hashlib.sha256(log.read_bytes()).hexdigest()
    assert document["sha256"] == {log.name: own}
    with zipfile.ZipFile(tmp_path / "compensator.fmu") as archive:
        page = unescape(archive.read("documentation/index.html").decode())
    assert own in page.split("Values")[1]
    learned = LearnedFile(tmp_path / "learned.json")
    for language, head in (("c", "compensator.h"), ("st", "compensator.st")):
        notes = provenance(learned, 0.6)
        write_compensator(tmp_path, language, notes=[*notes, "a */ (* b *) c"])
        text = (tmp_path / head).read_text()
        first = text[: text.index("*/" if language == "c" else "*)")]
        for words in (own, "60 % of the learned friction, because with the whole force", " c\n"):
            assert words in first
        for name, one in document["parameters"].items():
            assert f"{name} = {one['value']:.5g} {one['unit']}" in first


def strings(document):
    """Yield each text of plain data."""
    if isinstance(document, str):
        yield document
    elif isinstance(document, dict | list):
        for one in document.values() if isinstance(document, dict) else document:
            yield from strings(one)


def test_an_observer_without_a_trial_is_not_replaced_by_a_feedforward(sound):
    assert untried(sound, "ekbf").writes(force=True) == ""
    assert untried(sound).writes() == ""
    assert "no velocity loop can be closed: the mass is not known" in untried(sound).refusal


@pytest.mark.parametrize(
    ("shown", "frictionless", "said"),
    [
        ("identifiable", 0.99, "friction is not the problem: 99 % of the velocity error stays"),
        ("identifiable", 2.98, "without any the velocity error is 2.98 times as large"),
        (NOT_IDENTIFIABLE, 0.99, "no compensator"),
    ],
)
def test_friction_that_a_log_does_not_show_is_not_said_to_be_no_problem(shown, frictionless, said):
    known = {"F_c": SimpleNamespace(identifiability=shown)}
    learned = SimpleNamespace(trial=None, estimation=SimpleNamespace(known=known), refusal="it")
    learned.writes = lambda **_: ""
    sizes = {"measured": 1.0, "without": 1.0, "compensated": None, "frictionless": frictionless}
    loop = LoopShare("velocity", "mm/s", "it", **sizes, remedy="", remedied=0.1)
    assert said in _headline(learned, (), loop, force=False)


def test_the_verdict_tells_what_assumed_units_give_and_how_to_correct_a_force(sound):
    """Without units and gains nothing else shows that a force is in another unit."""
    scale = Finding("warning", "the force is out of scale", "9 times", "give F", spoils="values")
    faulty = replace(sound.estimation, faults=(scale,))
    faulty = replace(sound, implausible="the loop is another one", estimation=faulty)
    first, *others = verdict_of(faulty).doubts
    m = number(sound.estimation.known["m"].value, 3)
    assert f", which gives m = {m} kg and F_c = " in first
    assert others[0] == "the force is out of scale: 9 times; give F"
    confirmed = replace(sound.estimation, controller=SimpleNamespace(error=0.0))
    assert "state no unit" not in "".join(verdict_of(replace(sound, estimation=confirmed)).doubts)


def test_the_verdict_leaves_out_what_a_log_was_expected_to_show(sound):
    both = "times are uneven", "sigma_0 and sigma_1 are poorly identifiable"
    told = tuple(Finding("warning", what, "it") for what in both)
    doubts = verdict_of(replace(sound, findings=told)).doubts
    assert doubts[-1] == "warnings about the log: times are uneven"


def test_without_a_folder_the_verdict_tells_what_would_be_written(sound):
    assert lines(verdict_of(sound), None, None)[1].startswith("would write DIR/compensator.fmu")
    tuned = replace(verdict_of(sound), remedies=("'stickslip tune learned.json' searches it",))
    _, first, *others = lines(tuned, Path("out"), None)
    assert first.startswith("use         out/comp")
    assert any("'stickslip tune out/learned.json' searches it" in one for one in others)
    assert "without its observer" in sound.run
    assert not sound.run.endswith(",")
