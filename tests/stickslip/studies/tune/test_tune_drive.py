"""Tuning of a learned drive, simulated and real: what may change, what runs, what is taken."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest

import stickslip as ss
from stickslip import cli
from stickslip.catalog.parameters import LUGRE, PAPER, UNITS
from stickslip.cosim import Trapezoid
from stickslip.errors import LimitError, UsageError
from stickslip.identification.criteria.runs import Runs
from stickslip.learned.deploying import deployed_blocks
from stickslip.learned.file import LearnedFile
from stickslip.learned.writing import component_entry, loop_document, validation_document
from stickslip.loops import other_gains
from stickslip.loops.drive_loop import DriveLoop
from stickslip.loops.family_cost import FamilyCost, ratios
from stickslip.loops.other_gains import try_other_gains
from stickslip.models import load_model
from stickslip.output import Progress
from stickslip.presentation.quantity import number
from stickslip.servo.axis import Axis, Datasheet
from stickslip.servo.lanes import Lanes
from stickslip.servo.observer import design_observer
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.systems import Compensator, build_fmus, build_loop
from stickslip.servo.velocity_filter import Observer
from stickslip.servo.velocity_loop import close_velocity_loop
from stickslip.storage.codec import encode
from stickslip.studies.learn.recorded import gains_of
from stickslip.studies.tune import on_rig
from stickslip.studies.tune.run import PRESENT, TUNED, TuneSettings, masses_of, tune_drive
from stickslip.studies.tune.writing import draw_errors
from stickslip.thresholds import kept, rig_tuning
from stickslip.trial.benefit import TrialError, bench_of
from stickslip.trial.family import axis_values, in_loop
from tests.stickslip.rigs.test_file import RIG
from tests.stickslip.rigs.test_socket import served

pytestmark = pytest.mark.slow

AXIS, SHEET = Axis(5.557, 6.6135, 1e-4), Datasheet(peak_force=200.0, force_noise=0.0)
SLOW = close_velocity_loop(AXIS, 5e-4, 1e-3, 1000.0, 4e4)
CASCADE = SLOW.changed(K_x=20.0)
DESIGNED = design_observer(SLOW, SHEET.encoder_step, PAPER["F_c"])


@pytest.fixture(scope="module")
def learned(tmp_path_factory):
    """Write a learned.json with Table 2, a loop, a feedforward and an observer; return its path."""

    def write(loop=SLOW):
        observer = Compensator("observer", "dob", {**DESIGNED.observer.parameters(), "F_0": 2.0})
        path = tmp_path_factory.mktemp("learned") / "learned.json"
        entries = {
            "parameters": {n: {"value": PAPER[n], "unit": UNITS[n]} for n in LUGRE},
            "loop": loop_document(loop),
            "share": {"value": 0.8, "unit": "1"},
            "observer": component_entry(observer, rotary=False),
            "datasheet": encode(SHEET),
            "validation": validation_document(Trapezoid(0.02, 0.4, 0.1, 0.05)),
            "written": {"files": ["compensator.fmu", "observer.fmu"], "forced": False},
            "verdict": {"source": "axis.csv", "headline": "of before", "doubts": [DOUBT]},
        }
        path.write_text(json.dumps(entries))
        return path

    return write


DOUBT = "another loop than that of the log may have been described"


@pytest.fixture(scope="module")
def cost(learned):
    file = LearnedFile(learned(CASCADE))
    start = DriveLoop.of(file)
    with (
        file.bench(start.loop) as one,
        FamilyCost(one, start, masses_of(file), ["controller.K_p"]) as found,
    ):
        yield found


CHANGED = {
    "controller.K_p": 1500.0, "controller.K_x": 31.0, "controller.tau_f": 7e-4,
    "compensator.share": 0.5, "observer.share": 0.6,
}  # fmt: skip


def test_fmus_run_what_is_written_and_lanes_only_candidates(cost, monkeypatch):
    expected = cost.rows(cost.start)

    def refuse(*_):
        raise AssertionError("in lanes")

    monkeypatch.setattr(Lanes, "run", refuse)
    assert cost.rows(cost.start) == expected
    with pytest.raises(AssertionError, match="in lanes"):
        cost.together(np.array([[cost.start.parameters["controller.K_p"]]]))


def test_a_candidate_runs_as_a_loop_that_is_built_for_it(cost):
    one, cell = cost.start.with_values(CHANGED), cost.cells[0]
    drive, command = cell
    folder, T_s = cost.bench.fmus(drive.law, one.chain), one.loop.T_s
    whole = ss.Specification(
        build_loop(folder, one.loop, one.chain),
        step=T_s,
        stop=(len(command.v_cmd) - 1) * T_s,
        record=("drive.v",),
    )
    values = in_loop({**axis_values(one.loop, SHEET), **drive.parameters})
    optics = {"drive.noise": False}
    with Runs(whole) as runs:
        v = runs.run(values | optics, one.loop.commands(command.v_cmd))["drive.v"]
    expected = np.sqrt(np.mean((v - command.v_cmd) ** 2))
    row, *_ = cost.rows(one, [cell])
    assert row.compensated == pytest.approx(expected, rel=1e-9)
    assert row.without != pytest.approx(expected, rel=0.05)


def test_the_present_loop_leaves_its_own_error_in_moves_of_every_length(learned):
    file, far = LearnedFile(learned()), Trapezoid(0.1, 2.0, 0.1, 0.05)
    start, coarse = DriveLoop.of(file), replace(SHEET, encoder_step=1e-6)
    bench = bench_of(
        file.law, start.loop, file.friction, file.drives, command=far, datasheet=coarse
    )
    with bench as one, FamilyCost(one, start, masses_of(file), ["controller.K_p"]) as cost:
        names = [command.name for drive, command in cost.cells if drive is cost.cells[0][0]]
        assert len(names) > len({*names})
        assert {row.ratio for row in cost.rows(start)} == {1.0}


def test_the_peak_sensitivity_is_the_largest_at_the_masses(cost):
    fast = replace(DESIGNED.observer.filter, L_d=5.0 * DESIGNED.observer.filter.L_d)
    one = cost.start.with_values({"observer.L_d": fast.L_d, "controller.K_p": 1500.0})
    masses = [k * AXIS.m for k in (0.9, 1.0, 1.1)]
    expected = max(peak_sensitivity(one.loop, Observer(fast), m) for m in masses)
    assert cost.sensitivity(one) == pytest.approx(expected, rel=5e-3)
    alone = max(peak_sensitivity(one.loop, None, m) for m in masses)
    assert alone != pytest.approx(expected, rel=0.02)


def test_an_observer_that_is_unstable_by_itself_is_a_candidate_that_fails(cost):
    diverging = cost.start.with_values({"observer.L_v": 1e6})
    assert cost.excess(diverging) == np.inf


def test_beyond_a_limit_a_candidate_costs_more_the_farther_it_is(cost):
    within, beyond, farther = (cost(np.array([K_p])) for K_p in (1200.0, 5500.0, 6500.0))
    assert within < 10.0 < beyond < farther
    with pytest.raises(ss.ga.CandidateFailed):
        cost(np.array([5e4]))


def test_other_gains_are_reported_that_a_search_would_take(cost):
    start = replace(cost.start, feedforward=None, observer=None)
    with FamilyCost(cost.bench, start, cost.masses, ()) as plain:
        found = try_other_gains(plain)
        gains = {f"controller.{n}": k * getattr(CASCADE, n) for n, k in found.factors.items()}
        one = start.with_values(gains)
        left = ratios(plain.rows(one, plain.few))
        assert found.peak_sensitivity == (plain.sensitivity(start), plain.sensitivity(one))
        assert plain.excess(one) <= 1.0
    assert found.worst == max(left.values()) <= kept.LOOP_WORSE
    mean = np.exp(np.mean([np.log(ratio) for key, ratio in left.items() if "RMS" in key]))
    assert found.error == pytest.approx(mean)
    assert found.error < 0.9
    assert f"{found.factors['K_p']:g} times K_p" in found.sentence


def test_gains_beyond_a_limit_are_not_reported(cost, monkeypatch):
    monkeypatch.setattr(other_gains, "CASCADE", {"K_p": (1.0, 10.0)})
    assert "none of 1 loops tried" in try_other_gains(cost).sentence


class Heard(Progress):
    """The stages, each with how many steps its last one is to have."""

    def __init__(self):
        self.steps = {}

    def stage(self, name):
        self.steps[name.partition(" ")[0]] = "none"

    def move(self, _done, of, *_):
        self.steps[[*self.steps][-1]] = of


def test_noise_of_the_motor_force_is_that_of_the_file(learned):
    """A file that states none has none; one without a data sheet is of the paper's stage."""
    path = learned()
    document = json.loads(path.read_text())
    for sheet, noise in (
        ({**document["datasheet"], "force_noise": {"value": 0.3, "unit": "N"}}, 0.3),
        ({"encoder_step": {"value": 1e-6, "unit": "m"}}, 0.0),
        (None, 0.05),
    ):
        own = {name: one for name, one in document.items() if name != "datasheet"}
        path.write_text(json.dumps(own | ({"datasheet": sheet} if sheet else {})))
        assert LearnedFile(path).datasheet.force_noise == noise


def test_no_motion_gets_worse_and_what_is_fixed_stays_to_the_bit(learned):
    file = LearnedFile(learned())
    fixed = ("controller.K_i", "observer")
    with Heard() as heard:
        found = tune_drive(file, TuneSettings(fixed=fixed, evaluations=20, seed=1), heard)
    assert heard.steps == {"building": 1, "tuning": "none", "running": None}
    before, after = found.start.tunable, found.best.tunable
    assert found.is_better
    assert set(found.names) == {"controller.K_p", "controller.tau_f", "compensator.share"}
    for name in before.keys() - {*found.names} - {f"compensator.{one}" for one in PAPER}:
        assert after[name] == before[name]
    assert before["controller.K_i"] == SLOW.K_i
    assert max(found.ratios.values()) <= kept.LOOP_WORSE
    assert min(found.ratios.values()) < 0.9
    assert found.Ms[1] <= kept.SENSITIVITY
    (panel,) = draw_errors(found).axes  # in mm/s, first in the motion and friction of the first row
    first = [one for one in found.rows if (one.command, one.level) == (found.rows[0].command, 1.0)]
    for line, name in zip(panel.get_lines(), ("without", "compensated"), strict=True):
        squares = [getattr(one, name) ** 2 for one in first]
        assert line.get_ydata()[0] == pytest.approx(1e3 * np.sqrt(np.mean(squares)))


def test_where_nothing_is_better_the_present_loop_stays(learned, capsys):
    narrow = {"controller.K_p": (100.0, 200.0)}
    settings = TuneSettings(narrow, ("controller", "observer", "compensator"), evaluations=12)
    found = tune_drive(LearnedFile(learned()), settings)
    assert found.best is found.start
    assert set(found.ratios.values()) == {1.0}
    assert "stays as it is" in found.sentence
    assert repr(found) == f"TunedDrive({found.sentence})"
    words = ["--set-range", "controller.K_p=100:200", "--evaluations", "12", "--workers", "1"]
    assert cli.main(["tune", str(found.learned.path), *words]) == 0
    printed = capsys.readouterr().out
    assert "stays as it is" in printed
    assert "the true one is expected" not in printed  # of a loop that did not change


def test_the_files_have_the_tuned_loop(learned, tmp_path, capsys):
    path = learned(CASCADE)
    words = ["tune", str(path), "--out", str(tmp_path), "--evaluations", "60", "--workers", "1"]
    assert cli.main([*words, "--set-range", "controller.K_x=15:60"]) == 0
    assert "of the tracking error of the present one" in capsys.readouterr().out
    assert (tmp_path / "errors.svg").exists()
    tuned = LearnedFile(tmp_path / "tuned.json")
    after = {one["parameter"]: one["after"] for one in tuned.document["tuning"]["parameters"]}
    assert 15.0 <= tuned.loop.K_x == after["controller.K_x"] <= 60.0
    assert tuned.loop.K_p == after["controller.K_p"] != CASCADE.K_p
    assert tuned.share == after["compensator.share"]
    blocks = {name: ss.Fmu(tmp_path / f"{name}.fmu") for name in ("compensator", "observer")}
    start = {name: float(v.start) for name, v in blocks["compensator"].variables.items() if v.start}
    assert start["F_c"] == pytest.approx(tuned.share * PAPER["F_c"], rel=1e-12)
    assert start["loop_A[1,1]"] == pytest.approx(tuned.loop.nominal.A[0, 0], rel=1e-12)
    observed = blocks["observer"].variables
    assert float(observed["L_d"].start) == pytest.approx(after["observer.L_d"], rel=1e-12)
    assert float(observed["F_0"].start) == 2.0  # of the drive, whose models have none
    assert "observer.F_0" not in after
    check_deployment(tmp_path, tuned)


def check_deployment(folder, tuned):
    """The code has the values of the FMUs, the page the gains to enter, with those before."""
    for block in deployed_blocks(tuned):
        starts = {v.name: v.start for v in ss.Fmu(folder / f"{block.name}.fmu").variables.values()}
        own = {v.name: v.start for v in block.variables if v.role == "parameter"}
        assert own == {name: starts[name] for name in own}
        assert (folder / "deploy" / f"{block.name}.c").exists()
    verdict = tuned.document["verdict"]
    assert (verdict["source"], verdict["doubts"]) == ("axis.csv", [DOUBT])
    assert verdict["headline"] == tuned.document["tuning"]["sentence"]
    assert ["uncertain", DOUBT] in verdict["lines"]
    share, *_ = [text for key, text in verdict["lines"] if key == "set" and ".share" in text]
    assert re.fullmatch(r"\w+\.share = [\d.]+, before [\d.]+", share)
    assert (folder / "deploy" / "added_force.xml").exists()
    head = (folder / "deploy" / "added_force.h").read_text(encoding="utf-8")
    head = re.sub(r"\n[ *]*", " ", head)
    for text in (DOUBT, tuned.document["tuning"]["sentence"]):
        assert text in head
    for name in ("K_x", "K_p", "K_i", "tau_f", "T_s", "velocity_feedforward"):
        assert f"{name} = {getattr(tuned.loop, name):.5g}" in head
    page = re.sub("<[^>]*>", "", (folder / "deploy" / "steps.html").read_text(encoding="utf-8"))
    used = {"Position": tuned.loop.K_x, "Acceleration": tuned.loop.m_ff}
    assert {name: f"{name} command" in page for name in used} == {n: x > 0 for n, x in used.items()}
    enter = next(line for line in page.splitlines() if "enter the tuned gains" in line.lower())
    stop = page[page.index("Set the gain to 0 at once") :]
    gains = 0
    for one in tuned.document["tuning"]["parameters"]:
        name = one["parameter"].removeprefix("controller.")
        is_gain = name != one["parameter"] and number(one["before"]) != number(one["after"])
        gains += is_gain
        for text, when in ((enter, "after"), (enter, "before"), (stop, "before")):
            shown = f"{name} = {number(one[when])} {one['unit']}"
            assert (shown in text) == is_gain
    assert gains > 1
    assert "not added yet" in enter
    of_all = [one for one in tuned.document["tuning"]["ratios"] if one["of"] == "RMS"]
    assert len(of_all) > 3
    for one in of_all:
        left = number(100.0 * one["ratio"], 2)
        assert f"{one['motion']}, {one['figure']}: {left} %" in page


def test_ratios_are_of_all_drives_and_of_each():
    rows = tuple(
        TrialError(1.0, drive, without=a, compensated=b, command="creep")
        for drive, a, b in (("one", 3.0, 1.5), ("other", 4.0, 2.0), ("third", 1e-3, 4e-3))
    )
    found = ratios((*rows, TrialError(1.0, "away", np.inf, 1.0, command="creep")))
    assert found["creep", "velocity", "RMS"] == pytest.approx(0.5, rel=1e-4)
    assert found["creep", "velocity", "each"] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("ranges", "fixed", "says"),
    [
        ({"controller.K_q": (1.0, 2.0)}, (), "no 'controller.K_q'"),
        ({"controller.K_p": (1.0, 2.0, 3.0)}, (), r"expected \(lowest, highest\) of each"),
        ({}, ("observr",), "no 'observr'"),
        ({}, ("controller", "observer", "compensator"), "nothing is left"),
    ],
)
def test_what_cannot_be_tuned_is_refused(learned, ranges, fixed, says):
    with pytest.raises(UsageError, match=says):
        ss.tune(learned(), ranges, fixed=fixed)


def test_a_limit_below_the_friction_is_refused(learned):
    with pytest.raises(UsageError, match="5 N and Coulomb friction 6 N: the drive cannot"):
        ss.tune(learned(), force_limit=5.0)


def test_a_file_without_a_loop_is_refused(learned):
    path = learned()
    document = json.loads(path.read_text())
    del document["loop"]
    path.write_text(json.dumps(document))
    with pytest.raises(UsageError, match="contains no loop; learn with the controller"):
        ss.tune(path)


def test_a_gain_of_an_observer_is_searched_within_the_range_of_its_model(learned):
    """The exponent mu of an observer of Coulomb friction is 0.5 to 3, and begins at 2."""
    start = DriveLoop.of(LearnedFile(learned(CASCADE)))
    model = load_model("momentum_observer")
    values = {one.name: one.start for one in model.variables if one.role == "parameter"}
    friedland = Compensator("observer", "momentum_observer", {**values, "mu": 2.0, "coulomb": True})
    genes = {one.name: one for one in replace(start, observer=friedland).problem({}).genes}
    assert (genes["observer.mu"].lower, genes["observer.mu"].upper) == (0.5, 3.0)


def test_a_search_of_feedforward_begins_with_the_learned_mass(learned):
    start = DriveLoop.of(LearnedFile(learned(CASCADE)))
    assert start.loop.m_ff == 0.0
    (gene,) = (g for g in start.problem({"controller.m_ff": (0.0, 9.0)}).genes if "m_ff" in g.name)
    assert gene.start == start.loop.axis.m


BRIEF = {"evaluations": 12, "seed": 1}


class Bench(ss.FmuRig):
    """A drive that remembers its commands, and that a limit may end in one of them."""

    def __init__(self, fmus, fails=None, limits=None):
        super().__init__(fmus, SHEET, SLOW.T_s, limits=limits)
        self.commands, self._fails = [], fails

    def move(self, command):
        self.commands.append(command)
        if len(self.commands) == self._fails:
            raise LimitError("following error 3 m")
        return super().move(command)


def test_the_drive_runs_few_motions_and_takes_what_helps(fmus, learned):
    rig = Bench(fmus)
    found = ss.tune(learned(), rig=rig, motions=6, **BRIEF)
    shown = found.on_rig
    assert len(shown.motions) == len(rig.commands) <= shown.budget == 6
    assert [one.loop for one in shown.motions[:3]] == 3 * [PRESENT]
    assert found.is_better
    assert found.start.observer is found.best.observer is None
    assert found.Ms[1] <= kept.SENSITIVITY
    means = {
        name: np.exp(np.mean(np.log([one.ratios for one in shown.motions if one.loop == name])))
        for name in (PRESENT, TUNED)
    }
    assert means[TUNED] < 0.9 < means[PRESENT] == pytest.approx(1.0)
    last = rig.commands[-1]
    assert gains_of(last.loop) == gains_of(found.best.loop) != gains_of(SLOW)
    moved = last.loop.commands(last.velocity)["v_cmd"]
    v = np.gradient(ss.FmuRig.move(rig, last).x_enc, rig.T_s)
    true = np.sqrt(np.mean((v - moved) ** 2))
    assert shown.motions[-1].errors[0] <= true  # low-passed, without the steps of the encoder


def test_on_another_drive_than_learned_the_present_gains_are_set_again(tmp_path, learned):
    build_fmus(tmp_path, {"m": 1.2, "tau_i": 2e-3})
    rig = Bench(tmp_path)
    found = ss.tune(learned(), rig=rig, **BRIEF)
    shown = found.on_rig
    assert not found.is_better
    assert any(one in shown.stopped for one in ("oscillates", "times that of the present loop"))
    assert "the present gains are set again" in shown.sentence
    assert len(rig.commands) == len(shown.motions) + 1 <= shown.budget
    still = rig.commands[-1]
    assert gains_of(still.loop) == gains_of(SLOW)
    assert not still.velocity.any()
    assert shown.motions[-1].loop != PRESENT
    assert all(max(one.ratios) <= rig_tuning.WORSE for one in shown.motions[:-1])


def test_a_limit_ends_it_and_one_of_the_present_loop_is_an_error(fmus, learned, monkeypatch):
    rig = Bench(fmus, fails=3)
    found = ss.tune(learned(), rig=rig, motions=4, **BRIEF)
    assert "following error 3 m" in found.on_rig.stopped
    assert found.best is found.start
    assert len(rig.commands) == 4
    assert gains_of(rig.commands[-1].loop) == gains_of(SLOW)
    better = replace(found, best=found.start.with_values({"controller.K_p": 1200.0}))
    monkeypatch.setattr(on_rig, "tune_drive", lambda *_, **__: better)
    with pytest.raises(LimitError, match="following error 3 m"):
        ss.tune(learned(), rig=Bench(fmus, fails=1), motions=4)
    narrow = ss.RigLimits(travel=(-1e-6, 1e-6), speed=1.0, force=100.0, following_error=1.0)
    with pytest.raises(UsageError, match="no motion of the trial keeps the limits"):
        ss.tune(learned(), rig=Bench(fmus, limits=narrow))


def test_what_a_rig_cannot_run_is_refused(fmus, learned):
    slower = Bench(fmus)
    slower.T_s = 1e-3
    with pytest.raises(UsageError, match=r"T_s = 0\.0005 s, and drive\.fmu 0\.001 s"):
        ss.tune(learned(), rig=slower)
    with pytest.raises(UsageError, match="expected a learned"):
        ss.tune("loop.ssp", rig=slower)


@pytest.mark.thorough
def test_the_command_keeps_its_motions_and_writes_what_the_drive_showed(
    fmus, learned, tmp_path, capsys
):
    path = learned(replace(SLOW, K_p=SLOW.K_p))
    described, out = tmp_path / "rig.toml", tmp_path / "tuned"
    with served(fmus) as (drive, port):
        described.write_text(RIG.format(port=port))
        words = ["tune", path, "--rig", described, "--motions", 4, "--evaluations", 12]
        words = [*map(str, words), "--seed", "1", "--workers", "1", "--out", str(out)]
        for _ in range(2):  # the second takes the logs of the first
            assert cli.main(words) == 0
            motions = drive.motion
            shown = capsys.readouterr()
        assert motions == drive.motion
    assert "an observer would have to run in the drive" in shown.err
    assert "of at most 4 motions" in shown.out
    document = json.loads((out / "tuned.json").read_text())
    assert "observer" not in document
    assert document["written"]["files"] == ["compensator.fmu"]
    assert len(document["tuning"]["on_rig"]["motions"]) == document["tuning"]["on_rig"]["used"] <= 4
    assert not (out / "observer.fmu").exists()
    assert (out / "compensator.fmu").exists()
    assert cli.main(["tune", "--rig", str(described)]) != 0
    assert "stickslip learn --rig" in capsys.readouterr().err
