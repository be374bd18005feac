"""The arena on a few drives, with small budgets; its metrics on motions with known figures."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pandas as pd
import pytest
from matplotlib import pyplot as plt

from stickslip import cosim, models
from stickslip.catalog.parameters import PAPER
from stickslip.cli import main
from stickslip.compensators import entrants as registry
from stickslip.compensators import names
from stickslip.compensators.entrants import Coarse, TunedEntrant, default_names, entrant, own_part
from stickslip.errors import UsageError
from stickslip.models import UnknownLaw
from stickslip.models.export.units import force_and_length
from stickslip.presentation.quantity import number
from stickslip.servo.axis import Datasheet
from stickslip.servo.chain_response import ChainResponse
from stickslip.servo.sensitivity import peak_sensitivity
from stickslip.servo.velocity_loop import close_velocity_loop
from stickslip.storage import UNFINISHED
from stickslip.studies.arena import comparison as arena_comparison
from stickslip.studies.arena import page as arena_page
from stickslip.studies.arena import protocol
from stickslip.studies.arena.comparison import Comparison
from stickslip.studies.arena.comparison import arena as arena_of
from stickslip.studies.arena.course import Course
from stickslip.studies.arena.drive_names import drive_names
from stickslip.studies.arena.drives import default_drives, learned_drive, read_drives
from stickslip.studies.arena.metrics import Trace, figures
from stickslip.studies.arena.motion_commands import COMMANDS, RADIUS, TRAINING
from stickslip.studies.arena.protocol import Plan, build, run_arena
from stickslip.studies.arena.table import ALL, COLUMNS, RELATIVE, arena_table, relative_errors
from stickslip.studies.arena.tuning import Budget, tune
from stickslip.studies.arena.validation import WORST, validate, validate_changed
from stickslip.studies.arena.writing import write_arena
from stickslip.work.jobs import Execution

SMALL = Budget(10, 1000.0)
KEPT = ("state", "memory")
NAMES = ("none", "pi", "static", "lugre", "lugre_network", "static+ekbf")
COMPARED = ("none", "pi", "lugre")
EXPERIMENTS = ("lugre_identified", "lugre_fitted")


def drives(*names):
    return [drive for drive in default_drives() if drive.name in names]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fmus")
    build(folder, Plan(drives("lugre"), (*NAMES, *EXPERIMENTS)))
    return folder / "lugre"


@pytest.fixture(scope="module")
def loop():
    return drives("lugre")[0].loop


@pytest.fixture(scope="module")
def arena(tmp_path_factory):
    """Return a whole arena, and its folder."""
    folder = tmp_path_factory.mktemp("arena")
    plan = Plan(drives("lugre", "heavy"), COMPARED, SMALL, starts=1)
    found = run_arena(plan, folder, Execution())
    write_arena(found, arena_table(found), folder)
    return found, folder


def error(built, loop, name, values, command="T"):
    chosen = [COMMANDS[command]]
    found = validate(built, loop, entrant(name), TunedEntrant(loop, values), chosen, 2).figures
    return np.median(next(runs for key, runs in found.items() if key[1] == "error"))


def test_every_law_and_every_compensator_competes_without_being_named():
    parts = registry.parts()
    assert {*models.law_names()} <= {*parts}
    with_ports = {name for name in models.model_names() if models.load_model(name).ports}
    assert {part.model for part in parts.values()} - {""} == with_ports
    assert "adaptive_scale" not in default_names()  # adds nothing without a feedforward
    assert len(entrant("lugre+adaptive_scale").chain) == 2
    assert {drive.law for drive in default_drives()} == {*models.law_names()}
    for name in default_names():
        problem = entrant(name).problem(Coarse(6.0, 0.04))
        assert (problem is None) == (name in ("none", *EXPERIMENTS))
        if not any(part.controller for part in entrant(name).parts) and name != "none":
            assert f"pi+{name}" in default_names()


def test_a_compensator_without_an_entry_enters_with_the_parameters_of_its_model(monkeypatch):
    content = names.content()
    for name in ("static", "ekbf"):
        del content[name]
    uncached = names.part_names.__wrapped__
    for module in (names, registry):
        monkeypatch.setattr(module, "content", lambda: dict(content))
        monkeypatch.setattr(module, "part_names", uncached)
    found = registry.parts.__wrapped__()
    assert [gene.name for gene in found["dob"].genes(Coarse(6.0, 0.04))] == ["dob.w_q", "dob.share"]
    monkeypatch.undo()
    (name,) = {*found} - {*registry.parts()}
    assert name == "static_feedforward"
    genes = {gene.name.partition(".")[2] for gene in found[name].genes(Coarse(6.0, 0.04))}
    assert {"F_c", "v_t"} <= genes


def test_forces_and_lengths_follow_the_drive_for_every_entrant(loop):
    """No constant holds for the paper's stage only: forces by 50, lengths and speeds by 4."""

    def parameters(part, coarse):
        genes = {g.name.removeprefix(f"{part.name}."): g.start for g in part.genes(coarse)}
        return part.parameters(genes, loop, coarse, Datasheet())

    for part in registry.parts().values():
        if not part.model or part.design:  # gains of a filter follow from force and encoder
            continue
        model = models.load_model(part.model, part.law.name if part.law else None)
        units = {v.name: v.unit or "1" for v in model.variables}
        starts = {v.name: v.start for v in model.variables if v.role == "parameter"}
        here, there = (parameters(part, Coarse(*one)) for one in ((6.0, 0.04), (300.0, 0.16)))
        for name, unit in units.items():
            force, length = force_and_length(unit)
            if not starts.get(name) or not (force or length) or name in part.ports.axis:
                continue
            expected = 50.0**force * 4.0**length
            assert there[name] / here[name] == pytest.approx(expected), (part.name, name)


def test_the_fmus_of_every_entrant_take_its_start_values(tmp_path, loop):
    every, coarse = [entrant(name) for name in registry.parts()], Coarse(6.0, 0.04)
    build(tmp_path, Plan(drives("lugre"), [*registry.parts()]))
    assert (tmp_path / "lugre/stage.fmu").exists()  # for the entrants that identify the drive
    for one in every:
        problem = one.problem(coarse)
        genes = {gene.name: gene.start for gene in problem.genes} if problem else {}
        tuned = one.tuned(genes, loop, coarse, Datasheet())
        with Course(tmp_path / "lugre", one.base(loop), one, 10, ("drive.x",)) as course:
            assert np.isfinite(course.run(tuned, np.full(10, 0.01))["drive.x"]).all(), one.title


def test_composite_feedback_is_as_robust_as_its_worst_linear_loop(built, loop):
    one, coarse = entrant("cnf"), Coarse(6.0, 0.04)
    genes = {gene.name: gene.start for gene in one.problem(coarse).genes}
    for damping in (0.05, 1.6):
        tuned = one.tuned({**genes, "cnf.gamma_v": damping}, loop, coarse, Datasheet())
        stiff = replace(tuned.loop, K_x=0.0)
        damped = close_velocity_loop(
            loop.axis, loop.T_s, loop.tau_f, stiff.K_p + damping * loop.K_p, stiff.K_i
        )
        with ChainResponse(built, loop, one.chain) as response:
            found = tuned.robustness(response, 6.0)
        expected = max(peak_sensitivity(tuned.loop), peak_sensitivity(damped))
        assert found.peak == pytest.approx(expected, rel=0.05)


def test_changed_drives_have_other_errors(built, loop):
    drive = drives("lugre")[0]
    changes = drive.changes("T", "R")
    assert changes["friction x 0.5"][1]["F_c"] == pytest.approx(0.5 * PAPER["F_c"])
    assert changes["friction x 0.5"][1]["sigma_0"] == pytest.approx(0.5 * PAPER["sigma_0"])
    assert "v_s" not in changes["friction x 0.5"][1]
    found = validate_changed(
        built, loop, entrant("none"), TunedEntrant(loop, {}), changes, 1, Datasheet()
    )
    ratios = {key[1].partition("ratio ")[2]: values[0] for key, values in found.items()}
    assert ratios["friction x 0.5"] == pytest.approx(0.5, abs=0.1)
    assert ratios["friction x 1.5"] == pytest.approx(1.5, abs=0.1)
    assert ratios["noise x 3"] > 1.0
    ((worst,),) = (values for key, values in found.items() if key[1] == WORST)
    assert worst == max(values[0] for key, values in found.items() if key[0] == "T")
    assert found["R", "error per encoder step", "1/s"][0] > 0.0


def test_tuning_comes_near_the_exact_feedforward(built, loop):
    """Within seconds of motion that allow 12 evaluations."""
    one, sheet = entrant("static"), Datasheet()
    duration = sum(len(command.sample(loop.T_s)) for command in TRAINING) * loop.T_s
    found = tune(built, loop, one, Budget(100, 12 * duration), 0, sheet)
    assert 0 < found.evaluations <= 12
    assert found.seconds == pytest.approx(found.evaluations * duration)
    assert found.soon <= found.seconds
    assert found.coarse.friction == pytest.approx(PAPER["F_c"], rel=0.05)
    tuned = found.tuned(one, loop, sheet)
    assert error(built, loop, "static", tuned.parameters) < 0.3 * error(built, loop, "none", {})


@pytest.mark.thorough
def test_experiments_show_a_drive_its_friction(built, loop):
    found = {name: tune(built, loop, entrant(name), SMALL, 0, Datasheet()) for name in EXPERIMENTS}
    errors, without = {}, error(built, loop, "none", {})
    for name, one in found.items():
        assert one.evaluations == 0
        assert one.learned[f"{name}.F_c"] == pytest.approx(PAPER["F_c"], rel=0.05)
        values = one.tuned(entrant(name), loop, Datasheet()).parameters
        errors[name] = error(built, loop, name, values)
        assert errors[name] < 0.3 * without
    assert found["lugre_fitted"].seconds > found["lugre_identified"].seconds > 100.0
    assert errors["lugre_fitted"] < 1.1 * errors["lugre_identified"]


def test_what_learns_is_validated_with_what_it_learned_and_learns_no_more(built, loop):
    one, sheet = entrant("lugre_network"), Datasheet()
    found = tune(built, loop, one, SMALL, 0, sheet)
    values = found.tuned(one, loop, sheet).parameters
    assert values["lugre_network.gamma"] == 0.0
    start = found.coarse.start("F_c", models.load_law("lugre"))
    learned = values["lugre_network.F_c"]
    assert abs(learned / PAPER["F_c"] - 1.0) < min(0.05, 0.5 * abs(start / PAPER["F_c"] - 1.0))


def test_the_table_has_every_cell(arena):
    found, folder = arena
    table = pd.read_csv(folder / "arena.csv.gz")
    assert list(table.columns) == COLUMNS
    assert not found.reasons
    assert not table["reason"].notna().any()
    for command in COMMANDS:
        rows = table[(table["command"] == command) & (table["metric"] == "error")]
        expected = {(d, e, t) for d in ("lugre", "heavy") for e in COMPARED for t in {d, "lugre"}}
        assert {*zip(rows["drive"], rows["compensator"], rows["tuned_on"], strict=True)} == expected
        assert (rows["worst"] >= rows["median"]).all()
        assert (rows["median"] > 0).all()
    means = table[(table["metric"] == RELATIVE) & (table["command"] == ALL)]
    own = means[(means["compensator"] == "pi") & (means["tuned_on"] == means["drive"])]
    assert own["median"].tolist() == pytest.approx([1.0, 1.0])
    costs = {"gain margin", "phase margin", "states", "binary size", WORST}
    assert costs <= {*table["metric"]}
    states = table[(table["metric"] == "states") & (table["compensator"] == "lugre")]
    kept = [v for v in models.load_model("compensator", "lugre").variables if v.role in KEPT]
    assert (states["median"] == len(kept)).all()
    peaks = table[table["metric"] == "Ms"]["median"]
    assert (peaks <= 2.2).all()
    assert not (folder / UNFINISHED).exists()


def test_python_gives_the_arena_of_the_command(arena, tmp_path):
    found, folder = arena
    comparison = Comparison(found, arena_table(found))
    here, carried = comparison.errors(), comparison.errors("C", carried=True)
    assert here.shape == carried.shape == (3, 2)
    assert here.loc["pi"].tolist() == pytest.approx([1.0, 1.0])
    means = np.exp(np.log(here).mean(axis=1))
    assert comparison.ranking["mean here"].to_dict() == pytest.approx(means.to_dict())
    assert repr(comparison) == repr(comparison.ranking)
    assert (comparison.sensitivity() <= 2.2).all(axis=None)
    assert not comparison.arena.reasons
    written = comparison.write(tmp_path / "written")
    for name in ("arena.csv.gz", "arena.html", "pareto.svg"):
        assert (written / name).read_bytes() == (folder / name).read_bytes()
    with mpl.rc_context({"backend": "agg"}):
        left, right = comparison.plot()
        plt.close("all")
    assert [text.get_text() for text in left.texts] == [f"{x:.2f}" for x in here.to_numpy().flat]
    assert right.get_title() == "tuned on lugre, carried over"


def test_the_options_of_python_are_those_of_the_command(built, tmp_path):
    """Drives and ports are tables; a FMU of the user that fails is named, and the others go on."""
    ports = {"inputs": {"v": "v_ref"}, "output": "F", "axis": {"lead": "tau_i"}}
    ports["values"] = {"v_t": -1}
    mine = shutil.copy(built / "static_feedforward.fmu", tmp_path / "mine.fmu")
    stage = {"axis_1": {"law": "dahl", "parameters": {"m": 3.0}}}
    given = {"own": {mine: ports}, "evaluations": 10, "seeds": 1}
    comparison = arena_of(["none"], stage, **given)
    assert comparison.errors().index.tolist() == ["none", "mine"]
    assert comparison.errors()["axis_1"]["none"] == pytest.approx(1.0)
    assert list(comparison.arena.reasons) == [("axis_1", "mine")]
    with pytest.raises(UsageError, match=r"ports of mine\.fmu: 'input' is unknown"):
        arena_of(["none"], stage, own={mine: {"input": {}}})
    with pytest.raises(UsageError, match="drives: drive 'axis_1': expected a table with law"):
        arena_of(["none"], {"axis_1": {"low": "dahl"}})


def test_a_killed_arena_resumes_to_the_same_results(arena, tmp_path):
    """Those of a larger arena, whose cells are the same."""
    plan = replace(arena[0].plan, entrants=("none", "pi"))

    def interrupt(done, total, _):
        assert total == 4
        if done == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=r"2 of 4 cells are kept"):
        run_arena(plan, tmp_path, Execution(), interrupt)
    with pytest.raises(UsageError, match="an earlier arena did not end"):
        run_arena(plan, tmp_path, Execution())
    resumed = run_arena(plan, tmp_path, Execution(workers=2, resume=True))
    assert resumed.kept == 2
    own = {key: one for key, one in arena[0].documents.items() if key[1] in plan.entrants}
    assert list(resumed.documents.items()) == list(own.items())
    other = replace(plan, seed=1, entrants=("none",), drives=plan.drives[:1])
    assert run_arena(other, tmp_path, Execution(resume=True)).kept == 0


def test_the_page_has_the_error_of_each_cell_and_of_each_motion(arena):
    found, folder = arena
    table, plan = arena_table(found), found.plan
    for carried, axes in enumerate(arena_page.draw_errors(plan, table).axes):
        wide = relative_errors(table, plan, carried=bool(carried))
        assert [text.get_text() for text in axes.texts] == [
            f"{value:.2f}" for value in wide.to_numpy().ravel()
        ]
    command = json.loads((folder / "manifest.json").read_text())["command"]
    assert command["evaluations"] == found.plan.budget.evaluations
    assert {"seed", "tunings", "starts", "seconds"} <= {*command}
    page = (folder / "arena.html").read_text(encoding="utf-8")
    slow = relative_errors(table, plan, carried=False, command="R")
    assert all(f">{number(value, 3)}<" in page for value in slow.to_numpy().ravel())
    assert "http" not in page.replace("http://www.w3.org", "")


def test_an_entrant_above_the_limit_is_marked(tmp_path):
    file = tmp_path / "drives.toml"
    file.write_text('[stiff]\nlaw = "lugre"\nloop = { K_p = 8000.0, K_i = 1e5 }\n')
    plan = Plan(read_drives(file), ["none", "ekbf"], Budget(10, 200.0), starts=1)
    found = run_arena(plan, tmp_path, Execution())
    table = arena_table(found)
    none = table[table["compensator"] == "none"]
    assert none["reason"].str.contains("Ms = ").all()
    assert found.reasons["stiff", "ekbf"].startswith("all 10 candidates failed")
    write_arena(found, table, tmp_path)
    assert "What failed" in (tmp_path / "arena.html").read_text(encoding="utf-8")
    texts = [text.get_text() for text in arena_page.draw_errors(plan, table).axes[0].texts]
    assert texts == ["1.00*", "–"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--compensators", "lugra"], "there is no 'lugra'; did you mean 'lugre'"),
        (["--compensators", "ekbf+lugre"], "'lugre' must come first"),
        (["--compensators", "static+static"], "each part can be there once only"),
        (["--only", "lugr"], "there is no drive 'lugr'; did you mean 'lugre'"),
        (["--seconds", "-1"], "expected a number above 0"),
    ],
)
def test_what_is_unknown_is_named(options, message, tmp_path, capsys):
    assert drive_names() == [drive.name for drive in default_drives()]
    with pytest.raises(UnknownLaw, match="there is no friction law 'luger'"):
        default_drives(["luger"])
    assert main(["arena", *options, "--out", str(tmp_path)]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected a table for each drive"),
        ('[a]\nlaw = "lugre"\ncolour = 1\n', "drive 'a': expected a table with law"),
        ('[a]\nlaw = "none"\n', "there is no friction law"),
        ('[a]\nlaw = "lugre"\nparameters = { F_x = 1.0 }\n', "drive has no parameter F_x"),
        ('[a]\nlaw = "lugre"\nloop = { K_p = 1.0 }\n', "expected K_p and K_i"),
        ("[a", "drives.toml"),
        ("[a]\nlaw = 3\n", "expected text as law"),
        ('[a]\nlaw = "lugre"\nparameters = 1\n', "parameters: expected a table of numbers"),
        ('[a]\nlaw = "lugre"\naxis = { mass = 1.0 }\n', "axis: 'mass' is unknown"),
        ('[a]\nlaw = "lugre"\naxis = { m = -1.0 }\n', "m is -1 kg"),
        ('[a]\nlaw = "lugre"\nspeed = 0\n', "speed: expected a number above 0"),
        ('[a]\nlaw = "lugre"\nparameters = { F_s = 300.0 }\n', "not below the force limit"),
        ('[a]\nlaw = "lugre"\nloop = { K_p = 8e5, K_i = 1.0 }\n', "unstable"),
    ],
)
def test_a_bad_file_of_drives_is_one_line(text, message, tmp_path):
    file = tmp_path / "drives.toml"
    file.write_text(text)
    with pytest.raises((UsageError, models.ModelError), match=message.replace("(", r"\(")):
        read_drives(file)


def test_a_loop_is_designed_for_the_mass_that_the_file_tells(tmp_path, monkeypatch):
    file = tmp_path / "drives.toml"
    file.write_text(
        '[own]\nlaw = "dahl"\nparameters = { m = 0.1, u_max = 9.0, encoder_step = 1e-8 }\n'
        '[other]\nlaw = "dahl"\nparameters = { m = 0.1 }\naxis = { m = 0.2, b = 0.0 }\n'
    )
    own, other = read_drives(file)
    assert (own.axis.m, own.sheet.peak_force, own.sheet.encoder_step) == (0.1, 9.0, 1e-8)
    assert (other.axis.m, other.axis.b, other.mass) == (0.2, 0.0, 0.1)
    assert other.loop.K_p / own.loop.K_p == pytest.approx(2.0, rel=0.1)
    built = []

    def record(name, folder, start=None, **_):
        folder.mkdir(parents=True, exist_ok=True)
        built.append((name, folder.name, start))

    monkeypatch.setattr(models, "build_fmu", record)
    build(tmp_path, Plan([own], ["none"]))
    assert ("velocity_controller", "own", {"u_max": 9.0}) in built


def test_the_winner_of_a_drive_is_exported_with_what_it_was_tuned_to(arena):
    found, folder = arena
    for drive in found.plan.drives:
        winner = json.loads((folder / "winners" / drive.name / "winner.json").read_text())
        errors = relative_errors(arena_table(found), found.plan, carried=False)[drive.name]
        assert winner["compensator"] == errors.idxmin()
        assert winner["relative_error"] == errors.min()
        for name, component in winner["components"].items():
            exported = cosim.Fmu(folder / "winners" / drive.name / f"{name}.fmu")
            for parameter, value in component["parameters"].items():
                assert float(exported.variables[parameter].start) == pytest.approx(value)
            assert (folder / "winners" / drive.name / f"{name}.c").exists()


@pytest.mark.thorough
def test_a_compensator_of_the_user_competes_like_the_others(tmp_path, monkeypatch):
    models.build_fmu("static_feedforward", tmp_path, called="mine")
    ports = tmp_path / "ports.toml"
    ports.write_text(
        'title = "My feedforward"\noutput = "F"\n'
        'inputs = { v = "v_ref", F_in = "F_added" }\naxis = { lead = "tau_i" }\n'
        "genes = { F_c = [1.0, 4.0, 20.0], v_t = [2e-5, 5e-4, 5e-3] }\n"
    )
    own = own_part(tmp_path / "mine.fmu", ports)
    plan = Plan(drives("lugre"), ["none", "mine", "mine+ekbf"], SMALL, 1, own=(own,))
    found = run_arena(plan, tmp_path / "out", Execution())
    table = arena_table(found)
    errors = table[(table["metric"] == "error") & (table["command"] == "T")]
    none, mine, both = errors.set_index("compensator")["median"][["none", "mine", "mine+ekbf"]]
    assert mine < 0.3 * none
    seeded = replace(plan, entrants=["mine"], starts=2, tunings=2)
    monkeypatch.setattr(protocol, "content", lambda: {"scattered": ["mine"]})
    (cell,) = run_arena(seeded, tmp_path / "seeds", Execution()).documents.values()
    alone = run_arena(replace(seeded, tunings=1), tmp_path / "one", Execution()).documents
    runs, single = (
        next(values for command, metric, _, values in one["validated"]["lugre"]["values"]
             if (command, metric) == ("T", "error"))
        for one in (cell, *alone.values())
    )  # fmt: skip
    assert len(runs) == len(single) == 2
    assert len({*runs}) == 2  # of each seed one, from the same start
    assert cell["tuned"]["lugre"]["cost"] <= alone["lugre", "mine"]["tuned"]["lugre"]["cost"]
    assert both < 0.5 * none


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('output = "F"\n', "expected inputs and output"),
        ('output = "F"\ninputs = { v = "speed" }\n', "inputs: 'speed' is unknown"),
        ('output = "F"\ninputs = { w = "v_ref" }\n', "has no variable 'w'"),
        ('output = "F"\ninputs = { v = "v_ref" }\ngenes = { F_c = [1.0] }\n', "genes: F_c: "),
        ('output = "F"\ncolour = 1\n', "'colour' is unknown"),
        ('name = "drive"\noutput = "F"\ninputs = { v = "v_ref" }\n', "the name 'drive' is taken"),
    ],
)
def test_bad_ports_are_one_line(text, message, tmp_path, built):
    ports = tmp_path / "ports.toml"
    ports.write_text(text)
    with pytest.raises(UsageError, match=message):
        own_part(built / "static_feedforward.fmu", ports)


@pytest.mark.thorough
def test_a_learned_drive_is_one_more_drive(tmp_path):
    drive = learned_drive(Path(__file__).parents[4] / "results" / "paper" / "learned.json")
    assert drive.name == "paper"
    assert drive.law == "lugre"
    assert drive.parameters["F_c"] == pytest.approx(PAPER["F_c"], rel=0.1)
    assert drive.loop.K_p == pytest.approx(drives("lugre")[0].loop.K_p, rel=0.1)
    slow = replace(drive, speed=0.02)
    found = run_arena(Plan([slow], ["none", "static"], SMALL, 1), tmp_path, Execution())
    assert not found.reasons
    document = found.documents["paper", "static"]["tuned"]["paper"]
    assert document["coarse"]["speed"] == pytest.approx(0.02, rel=0.1)
    assert document["coarse"]["friction"] == pytest.approx(PAPER["F_c"], rel=0.1)


T_S = 5e-4
LOOP = default_drives(["lugre"])[0].loop


def perfect(command):
    """Return a run that follows its command exactly."""
    v_cmd = command.sample(T_S)
    x_cmd = T_S * np.concatenate([[0.0], np.cumsum(v_cmd[:-1])])
    force = LOOP.axis.m * np.gradient(v_cmd, T_S) + LOOP.axis.b * v_cmd
    return Trace(T_S, v_cmd, v_cmd, x_cmd, force, v_cmd, 4e-7)


@pytest.mark.parametrize("command", COMMANDS.values(), ids=COMMANDS)
def test_a_command_is_no_training_ends_in_time_and_a_perfect_run_of_it_has_no_error(command):
    """And needs no further force; nothing was tuned on the command."""
    v_cmd, found = command.sample(T_S), figures(command, perfect(command), LOOP)
    assert abs(found["error"][0]) < 1e-15
    assert abs(found["effort"][0]) < 1e-12
    assert T_S * (len(v_cmd) - 1) == pytest.approx(command.motion.duration, abs=0.51 * T_S)
    for one in TRAINING:
        seen = one.sample(T_S)
        length = min(len(v_cmd), len(seen))
        assert np.abs(v_cmd[:length] - seen[:length]).max() > 1e-4, one.name


def test_the_error_of_the_creep_is_relative():
    run = perfect(COMMANDS["V"])
    found = figures(COMMANDS["V"], replace(run, v=1.1 * run.v), LOOP)
    assert found["error"] == (pytest.approx(0.1), "1")
    assert found["E_rms 0.1 mm/s"][0] == pytest.approx(0.1)


def test_a_glitch_has_the_height_of_the_step_after_a_reversal():
    command = COMMANDS["C"]
    run = perfect(command)
    spans = command.motion.regions["4 rad/s"]
    assert len(spans) == 3
    late = run.x.copy()
    for k, (begin, _) in enumerate(spans):
        at = round(begin / T_S)
        assert abs(run.v_cmd[at]) < 2e-3 * np.abs(run.v_cmd).max()
        late[at + 5 : at + 100] += (k + 1) * 1e-6
    found = figures(command, replace(run, x=late), LOOP)
    assert found["quadrant glitch 4 rad/s"][0] == pytest.approx(3e-6)
    assert found["quadrant glitch 1 rad/s"][0] == pytest.approx(0.0, abs=1e-12)
    assert np.ptp(run.x_cmd) == pytest.approx(2.0 * RADIUS, rel=1e-3)


def test_a_move_settles_when_its_error_stays_within_a_micrometre():
    command = COMMANDS["M"]
    run = perfect(command)
    (begin, _), _ = command.motion.regions["10 um"]
    t = T_S * np.arange(len(run.x))
    slow = run.x + np.where(t >= begin, 1e-5 * np.exp(-(t - begin) / 0.05), 0.0)
    found = figures(command, replace(run, x=slow), LOOP)
    assert found["settling 10 um"][0] == pytest.approx(0.05 * np.log(10.0), abs=2 * T_S)
    assert found["settling 5 um"][0] == 0.0
    travelled = T_S * np.abs(run.v_cmd).sum()
    assert travelled == pytest.approx(2.0 * sum((1e-6, 2e-6, 5e-6, 1e-5, 1e-4, 1e-3)), rel=1e-3)


@pytest.mark.parametrize(("rest", "beyond"), [(0, 1e-6), (1, -2e-6)])
def test_an_overshoot_is_relative_to_the_move(rest, beyond):
    command = COMMANDS["M"]
    run = perfect(command)
    (begin, end), t = command.motion.regions["10 um"][rest], T_S * np.arange(len(run.x))
    for error, expected in ((beyond, abs(beyond) / 1e-5), (-beyond, 0.0)):
        late = run.x + np.where((t > begin + 0.1) & (t < end), error, 0.0)
        found = figures(command, replace(run, x=late), LOOP)
        assert found["overshoot 10 um"][0] == pytest.approx(expected)


def test_reversals_at_rest_are_counted_where_they_exceed_the_encoder():
    command = COMMANDS["H"]
    run = perfect(command)
    t = T_S * np.arange(len(run.x))
    for size, expected in ((3e-6, 8.0), (3e-7, 0.0)):
        # 3 s of rest see 4.5 periods, thus 9 turning points; the last one has no swing after it.
        swing = run.x + size * np.cos(
            2.0 * np.pi * 1.5 * (t - command.motion.regions["hold"][0][0])
        )
        found = figures(command, replace(run, x=swing), LOOP)
        assert found["reversals at rest"][0] == expected
        assert found["error"][0] == pytest.approx(2.0 * size, rel=0.01)


def test_without_a_folder_nothing_is_kept_and_nothing_goes_on(monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt("interrupted; 2 of 4 cells are kept in a folder")

    monkeypatch.setattr(arena_comparison, "run_arena", interrupted)
    with pytest.raises(KeyboardInterrupt, match="without a folder nothing is kept"):
        arena_of(["pi"], only=["lugre"])
    with pytest.raises(UsageError, match="the folder in which the cells are kept"):
        arena_of(["pi"], only=["lugre"], resume=True)
    with pytest.raises(UsageError, match="compensators: expected one or more, got none"):
        arena_of([], only=["lugre"])
