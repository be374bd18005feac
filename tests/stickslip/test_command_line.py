"""The command line: words in any order, results, and one clear line for each error."""

import argparse
import io
import json
import os
import re
import shlex
import subprocess
import sys
import zipfile
from importlib.metadata import version

import numpy as np
import pandas as pd
import pytest

import stickslip as ss
from stickslip import cli, cosim, models
from stickslip.cli import COMMANDS, main
from stickslip.commands.simulate import add_isolation, isolation_of
from stickslip.errors import StickslipError
from stickslip.fmi.messages import installing
from stickslip.fmi.toolchain import PLATFORMS, host_platform
from tests.cosim.single import edited
from tests.stickslip.logs.rigid_drive import rigid_drive

LARGE = {"control", "fmpy", "matplotlib", "pandas", "scipy.linalg"}
"""Libraries that take seconds to load."""
SHORT = ["--stop", "0.02", "--step", "0.001"]
HERE = ["--platform", host_platform().tuple]


@pytest.fixture
def package(stage, tmp_path):
    """Return an .ssp of one stage that proposes no times."""
    system = cosim.System("loop")
    system.add("axis", stage, {"m": 2.0})
    system.expose("force", "axis.u")
    system.expose_output("speed", "axis.v")
    return cosim.write_ssp(system, tmp_path / "loop.ssp")


def run(*arguments):
    return main([str(argument) for argument in arguments])


def usage(capsys, *arguments) -> str:
    """Return the one line of a command that is called in a wrong way."""
    with pytest.raises(SystemExit, match="2"):
        run(*arguments)
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("stickslip: ")
    return line


def failure(capsys, *arguments) -> str:
    """Return the one line of a command that fails."""
    assert run(*arguments) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("stickslip: ")
    return line


@pytest.mark.parametrize(
    "arguments",
    [
        "FILE --set m=2 b=0 --record v x",
        "--set m=2 b=0 FILE --record v x",
        "--set m=2 b=0 --record v x FILE",
        "--record v FILE x --set m=2 b=0",
        "--record v x --set m=2 --set b=0 -- FILE",
        "--rec v x FILE --set=m=2 --set b=0",
        "--plot FILE --set m=2 b=0 --record v x",
    ],
)
def test_a_file_is_found_wherever_it_stands(arguments, stage, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = arguments.replace("FILE", str(stage)).split()
    assert run("simulate", *SHORT, "--json", "--set", "u=40", *words) == 0
    signals = {one["signal"]: one for one in json.loads(capsys.readouterr().out)["signals"]}
    assert [*signals] == ["stage.v", "stage.x"]
    # Above friction: the speed after 20 ms lies between that with and without friction.
    assert (40 - 9) / 2 * 0.02 < signals["stage.v"]["end"] < 40 / 2 * 0.02


def test_files_and_folders_are_found_after_patterns_and_choices(tmp_path, capsys):
    assert run("design", "--out", tmp_path) == 0
    assert run("verify", "--without", "*.fmu", tmp_path) == 0
    assert "intact" in capsys.readouterr().out
    platforms = ["x86_64-linux", "x86_64-windows"]
    for given, built in (["--platform", *platforms], platforms), ([], PLATFORMS):
        assert run("build", *given, "stage", "--fmi", "3", "--out", tmp_path / "fmus") == 0
        names = zipfile.ZipFile(tmp_path / "fmus" / "stage.fmu").namelist()
        assert {name.split("/")[1] for name in names if name.startswith("binaries/")} == {*built}


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ("simulat x.fmu", "there is no 'simulat'; did you mean 'simulate'?"),
        ("simulate --stpo 2 x.fmu", "there is no option '--stpo'; did you mean '--stop'"),
        ("learn --lwa auto x.csv", "there is no option '--lwa'; did you mean '--law'"),
        ("learn --law lugr x.csv", "--law: there is no 'lugr'; did you mean 'lugre'"),
        ("arena --laws lugr --out x", "--laws: there is no 'lugr'; did you mean 'lugre'"),
        ("export compensatr", "did you mean 'compensator'"),
        ("build --platform x86-linux", "--platform: there is no 'x86-linux'; did you mean"),
        ("simulate --set a=1 x x.fmu", "--set: expected NAME=VALUE, got 'x'"),
        ("simulate --plot x.bmp x.fmu", "x.bmp: expected a file that ends in .png, .svg or .pdf"),
        ("simulate x.fmu y", "there is no place for 'y'"),
        ("simulate --set a=1 b=2", "required: FILE.ssp|FILE.fmu"),
        ("simulate --st 1 x.fmu", "--st is short for several options: --stop, --step"),
        ("build --fmi 4", "--fmi"),
        ("reproduce --seeds 0", "--seeds"),
    ],
)
def test_what_is_mistyped_gets_a_suggestion(arguments, says, capsys):
    line = usage(capsys, *arguments.split())
    assert says in line
    assert "--help'" in line


def test_a_law_without_parameters_that_an_experiment_shows_is_not_learned(capsys):
    line = failure(capsys, "reproduce", "--law", "armstrong")
    assert "--law armstrong: no experiment shows its parameters; expected one of coul" in line
    with pytest.raises(StickslipError, match=r"armstrong.*: no experiment shows"):
        ss.LearnSettings(law="armstrong")


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("criterion", "output", "criterion: expected auto or loop or inverse, got output"),
        ("friction_range", "a", "friction_range: expected a number, got 'a'"),
        ("friction_range", (0.5, 1, 2), r"with 1 between them; got 0\.5 1\.0 2\.0"),
    ],
)
def test_settings_that_cannot_be_are_named(name, value, says):
    with pytest.raises(StickslipError, match=says):
        ss.LearnSettings(**{name: value})


def test_without_words_the_help_is_shown(capsys):
    assert run() == 0
    assert capsys.readouterr().out.startswith("usage: stickslip")


def test_a_missing_file_gets_the_name_of_one_that_is_there(tmp_path, capsys):
    (tmp_path / "axis.csv").write_text("")
    line = failure(capsys, "learn", tmp_path / "axis.cvs")
    assert line.endswith(f"No such file or directory; did you mean '{tmp_path / 'axis.csv'}'?")
    assert failure(capsys, "learn", tmp_path / "log.csv").endswith("No such file or directory")


@pytest.mark.parametrize("command", COMMANDS)
def test_a_help_has_the_common_options_and_examples_that_the_command_takes(command, capsys):
    with pytest.raises(SystemExit, match="0"):
        run(command, "--help")
    options, _, end = capsys.readouterr().out.partition("examples:\n")
    for words in (f"usage: stickslip {command}", "--json", "--quiet", "--verbose", "--debug"):
        assert words in options
    examples = re.findall(r"^ +stickslip (.+)$", end, re.MULTILINE)
    assert examples
    for words in map(shlex.split, examples):
        assert words[0] == command
        cli._parser(words).parse_args(words)


def test_rare_options_of_learn_are_listed_on_request_in_groups_of_five(capsys):
    shown = []
    for option in ("--help", "--help-all"):
        with pytest.raises(SystemExit, match="0"):
            run("learn", option)
        shown.append(capsys.readouterr().out)
    assert "--criterion" not in shown[0]
    assert "--criterion" in shown[1]
    groups = re.split(r"^\S.*:$", shown[1], flags=re.MULTILINE)
    assert all(len(re.findall(r"^  --\w", group, re.MULTILINE)) <= 5 for group in groups)


@pytest.mark.parametrize(
    ("arguments", "keys"),
    [
        ("simulate STAGE --stop 0.02", {"signals", "step", "points"}),
        ("info STAGE", {"variables", "experiment", "interfaces", "platforms", "tool"}),
        ("build stage --fmi 3 --out OUT", {"written"}),
        ("check STAGE --no-run", {"files", "version"}),
        ("design", {"K_p", "nominal_loop"}),
        ("plan --out OUT/plan.csv", {"written", "parts"}),
    ],
)
def test_json_is_a_document_and_quiet_is_nothing(arguments, keys, stage, tmp_path, capsys):
    words = arguments.replace("STAGE", str(stage)).replace("OUT", str(tmp_path)).split()
    assert run(*words, "--json") == 0
    document = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert keys <= {*document}
    for path in document.get("written", ()):
        (tmp_path / path).unlink()
    assert run("--quiet", *words) == 0
    assert capsys.readouterr() == ("", "")


def test_an_error_is_printed_with_quiet_too(tmp_path, capsys):
    assert run("simulate", "-q", "none.fmu") == 1
    assert "No such file" in capsys.readouterr().err
    (tmp_path / "manifest.json").write_text('{"files": {"a": "%s"}}' % ("0" * 64))
    assert run("verify", "-q", tmp_path) == 1
    out, err = capsys.readouterr()
    assert not out
    assert str(tmp_path) in err


def test_inputs_that_stay_at_their_start_values_are_named(stage, package, tmp_path, capsys):
    force = tmp_path / "force.csv"
    force.write_text("time,u,force\n0,0,0\n1,50,50\n")
    signal = force.with_name("u.csv")
    signal.write_text("time,u\n0,0\n1,50\n")
    for file, name in ((stage, "u"), (package, "force")):
        assert run("simulate", file, *SHORT) == 0
        warning = capsys.readouterr().err
        assert re.search(rf"warning: inputs that stay at .*: {name} = 0\S* N;", warning)
        assert run("simulate", file, *SHORT, "--set", f"{name}=3") == 0
        assert capsys.readouterr().err == ""
    assert run("simulate", stage, *SHORT, "--input", signal) == 0
    assert capsys.readouterr().err == ""


def test_a_package_runs_at_the_smallest_step_of_its_fmus(package, stage):
    proposed = cosim.Fmu(stage).experiment.step
    result = ss.simulate(package, stop=3.3 * proposed, parameters={"force": 10.0})
    assert np.diff(result.time) == pytest.approx(3.3 * proposed / 4)


def test_a_model_without_outputs_records_its_variables(stage, tmp_path, capsys):
    changes = {
        'causality="(input|output)"': 'causality="local"',
        "<ModelStructure>.*</ModelStructure>": "<ModelStructure/>",
        "<ModelExchange.*?</ModelExchange>|<ModelExchange[^>]*/>": "",
    }
    fmu = edited(stage, tmp_path / "mute.fmu", changes)
    assert run("simulate", fmu, *SHORT, "--json") == 0
    out, err = capsys.readouterr()
    assert "no outputs; local variables are recorded" in err
    assert {"stage.x", "stage.v", "stage.F_f"} <= {s["signal"] for s in json.loads(out)["signals"]}


def test_plot_writes_a_picture(stage, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run("simulate", stage, *SHORT, "--set", "u=9", "--plot") == 0
    assert capsys.readouterr().out.splitlines()[-1] == "stage.png"
    assert (tmp_path / "stage.png").read_bytes().startswith(b"\x89PNG")
    for name, begin in (("a.svg", b"<?xml"), ("a.pdf", b"%PDF")):
        assert run("simulate", stage, *SHORT, "--set", "u=9", "--plot", name) == 0
        assert (tmp_path / name).read_bytes().startswith(begin)


def test_results_are_written_as_the_suffix_says(stage, tmp_path, capsys):
    tables = []
    for name, read in (("a.csv", pd.read_csv), ("a.xlsx", pd.read_excel)):
        assert run("simulate", stage, *SHORT, "--set", "u=20", "--out", tmp_path / name) == 0
        tables.append(read(tmp_path / name))
    pd.testing.assert_frame_equal(*tables, check_dtype=False, rtol=1e-14)
    assert run("simulate", stage, *SHORT, "--out", tmp_path / "a.mat") == 1
    assert "a.mat: expected a file that ends in .csv, .parquet or .xlsx" in capsys.readouterr().err


def test_info_shows_what_an_fmu_contains(stage, capsys):
    assert run("info", stage) == 0
    shown = capsys.readouterr().out
    assert re.search(r"\n  m +Real +kg +5\.557 .*Moving mass\n", shown)
    assert "CoSimulation, ModelExchange" in shown
    assert "der(x)" not in shown
    assert run("info", stage, "--all") == 0
    assert "der(x)" in capsys.readouterr().out
    found = ss.info(stage)
    described = cosim.Fmu(stage)
    table = found.variables.set_index("name")
    assert [*table.index] == [*described.variables]
    assert table.start["m"] == described.variables["m"].start
    assert found.facts["experiment"]["step"] == described.experiment.step
    assert "Moving mass" in found._repr_html_()
    assert "Moving mass" in ss.Fmu(stage)._repr_html_()
    assert repr(found) == found.text()
    with pytest.raises(KeyError, match="no table 'variable'; did you mean 'variables'"):
        found["variable"]


def test_info_reads_an_fmu_of_another_platform(tmp_path, capsys):
    other = models.build_fmu("stage", tmp_path, platforms=[PLATFORMS["x86_64-windows"]])
    assert run("info", other, "--json") == 0
    document = json.loads(capsys.readouterr().out)
    assert document["platforms"] == ["win64"]
    assert {v["name"]: v["unit"] for v in document["variables"]}["sigma_0"] == "N/m"


def test_info_shows_what_a_system_contains(package, capsys):
    assert run("info", package) == 0
    shown = capsys.readouterr().out
    assert re.search(r"\n  force +N +axis\.u\n", shown)
    assert re.search(r"\n  speed +m/s +axis\.v\n", shown)
    found = ss.info(package)
    table = found.variables.set_index("name")
    assert table.start["axis.m"] == 2.0  # that of the package
    assert table.source["axis.u"] == "force"
    assert [*found["connections"].to_records(index=False)[0]] == ["force", "axis.u", "N"]


def test_what_the_output_cannot_encode_is_escaped(tmp_path, monkeypatch):
    system = cosim.System("schräg → ab")
    path = cosim.write_ssp(system, tmp_path / "e.ssp")
    output = io.TextIOWrapper(io.BytesIO(), encoding="ascii")
    monkeypatch.setattr(sys, "stdout", output)
    assert run("info", path) == 0
    assert rb"schr\xe4g \u2192 ab" in output.buffer.getvalue()


def test_only_foreign_fmus_are_isolated_unless_asked(monkeypatch):
    monkeypatch.setattr("sys.platform", "linux")
    parser = argparse.ArgumentParser()
    add_isolation(parser)
    chosen = {
        words: isolation_of(parser.parse_args(words.split()))
        for words in ("", "--no-isolate", "--isolate", "--timeout 3")
    }
    assert chosen == {
        "": "foreign",
        "--no-isolate": None,
        "--isolate": ss.cosim.Isolation(),
        "--timeout 3": ss.cosim.Isolation(timeout=3.0),
    }


def test_help_and_version_come_at_once():
    """Nothing is loaded for them; a whole command takes seconds to load."""
    code = "import sys; from stickslip.cli import main; main(sys.argv[1:])"
    loaded = f"import atexit, sys; atexit.register(lambda: print(*sys.modules)); {code}"
    for option, shown in (("--help", [*COMMANDS]), ("--version", [version("stickslip")])):
        command = [sys.executable, "-c", loaded, option]
        run = subprocess.run(command, check=True, capture_output=True, text=True)
        assert {*shown} <= {*run.stdout.split()}
        assert not {*LARGE, "numpy", "scipy", "lxml", "stickslip.cosim"} & {*run.stdout.split()}


def modules(code, *arguments):
    """Return the words that a program prints, a set for each line."""
    run = [sys.executable, "-c", f"import sys; from stickslip import cli\n{code}", *arguments]
    printed = subprocess.run(run, check=True, capture_output=True, text=True).stdout
    return [{*line.split()} for line in printed.splitlines()]


def test_arguments_are_parsed_before_anything_large_is_loaded():
    each = modules("for name in cli.COMMANDS: cli._parser([name]); print(*sys.modules)")
    for name, loaded in zip(COMMANDS, each, strict=True):
        assert COMMANDS[name].module in loaded
        assert not {*LARGE, "lxml", "stickslip.cosim", "tqdm"} & loaded, name


@pytest.mark.skipif(sys.platform == "win32", reason="shells that complete are of POSIX")
@pytest.mark.parametrize(
    ("typed", "offered"),
    [
        ("sim", {"simulate"}),
        ("learn log.csv --criterion ", {"auto", "inverse", "loop"}),
        ("simulate --re", {"--record", "--resume"}),
        ("simulate --stop=1 ./", {"./a.fmu", "./b.ssp", "./deep/"}),
        ("simulate a.fmu --stop ", set()),
        ("learn log.csv --compensator ek", {"ekbf", "ekbf2"}),
        ("arena --only armst", {"armstrong"}),
        ("build velocity_f", {"velocity_filter"}),
    ],
)
def test_a_shell_completes(typed, offered, tmp_path):
    """By the protocol of argcomplete: the line in the environment, words to descriptor 8."""
    for name in ("a.fmu", "b.ssp", "c.txt"):
        (tmp_path / name).touch()
    (tmp_path / "deep").mkdir()
    line = f"stickslip {typed}"
    asked = {"_ARGCOMPLETE": "1", "COMP_LINE": line, "COMP_POINT": str(len(line))}
    shell = ["/bin/sh", "-c", f"'{sys.executable}' -m stickslip 8>&1 9>/dev/null 1>/dev/null"]
    run = subprocess.run(
        shell, cwd=tmp_path, env=os.environ | asked, capture_output=True, text=True, check=True
    )
    assert {word.strip() for word in run.stdout.split("\013")} - {""} == offered
    assert not run.stderr


def test_mistakes_are_found_and_fmus_run_before_anything_large_is_loaded(stage):
    mistakes = (
        *(f"learn --compensator lugre+ekfb {__file__}", "learn none.csv"),
        *(f"learn {__file__} --unit position=furlong", "fleet none.csv --out fleet"),
        *("arena --compensators lugre+ekfb --out arena", "arena --only lugr --out arena"),
        *("compare none", "validate none.json"),
    )
    code = "for words in sys.argv[1:]: print(cli.main(words.split()), *sys.modules)"
    each = modules(code, *mistakes, f"simulate {stage} --stop=1 --quiet")
    for words, loaded in zip((*mistakes, "simulate"), each, strict=True):
        assert ("1" in loaded) == (words in mistakes)
        assert not LARGE & loaded, words
    assert "stickslip.cosim" in each[-1]


def test_checking_a_log_loads_no_more_than_it_computes_with(tmp_path):
    drive, log = rigid_drive(), tmp_path / "log.csv"
    signals = np.column_stack([drive.t, drive.position, drive.force, drive.velocity])
    head = "time [s],position [m],force [N],velocity [m/s]"
    np.savetxt(log, signals, delimiter=",", header=head, comments="")
    *_, loaded = modules("cli.main(sys.argv[1:]); print(*sys.modules)", "learn", log, "--check")
    assert "stickslip.identification.sliding.position_force" in loaded
    unneeded = {"control", "fmpy", "lxml", "matplotlib", "pandas", "stickslip.cosim"}
    unneeded |= {"scipy.signal", "scipy.stats"}
    assert not unneeded & loaded


def test_a_library_that_is_missing_is_named_before_the_run(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("stickslip.commands.simulate.find_spec", lambda _: None)
    for out, extra in (("a.xlsx", "excel"), ("a.parquet", "parquet")):
        line = failure(capsys, "simulate", tmp_path / "none.fmu", "--out", tmp_path / out)
        assert installing(extra) in line


def test_build_makes_both_versions_of_all_models(tmp_path, capsys):
    assert main(["build", *HERE, "--out", str(tmp_path)]) == 0
    assert len(capsys.readouterr().out.split()) == 2 * len(models.model_names())
    assert (tmp_path / "fmi3" / "drive.fmu").exists()


def test_build_takes_a_friction_law(tmp_path):
    words = ["build", "drive", "--law", "gms", "--fmi", "3", *HERE, "--out", str(tmp_path)]
    assert main(words) == 0
    described = zipfile.ZipFile(tmp_path / "drive.fmu").read("modelDescription.xml").decode()
    assert 'name="F_e[4]"' in described
    everything = ["build", "--law", "dahl", "--fmi", "2", *HERE, "--out", str(tmp_path / "all")]
    assert main(everything) == 0
    built = {path.stem for path in (tmp_path / "all").iterdir()}
    assert built == {name for name in models.model_names() if models.load_model(name).law}


def test_design_prints_what_was_asked_for(tmp_path, capsys):
    arguments = ["design", "--bandwidth", "80", "--phase-margin", "55", "--out", str(tmp_path)]
    assert main(arguments) == 0
    design = json.loads((tmp_path / "design.json").read_text())
    assert design["crossover_Hz"] == pytest.approx(80, rel=1e-6)
    assert design["phase_margin_deg"] == pytest.approx(55, rel=1e-6)
    assert "K_p" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("message", "arguments"),
    [
        ("there is no model 'stag'", "build stag"),
        ("stickslip build compensator --law dahl", "build dahl"),
        ("no friction law 'ghost'", "build --law ghost"),
        ("'nominal_loop' contains no friction law", "build nominal_loop --law gms"),
        ("no variable 'mm'", "simulate STAGE --set mm=1"),
        ("outside", "simulate STAGE --set m=-1"),
        ("foo", "simulate STAGE --record foo"),
        ("every = 0", "simulate STAGE --every 0"),
        ("or a step of 0.3333", "simulate STAGE --stop 1 --step 0.3"),
        ("a folder without a .fmu or .ssp", "check tests/control"),
        ("an FMU already", "export STAGE"),
        ("expected one step, less than the stroke", "plan --motion rotary --encoder 1048576"),
        ("expected a file", "simulate loop.xml"),
        ("expected a file .ssp or .fmu", "info a.xml"),
        ("out of reach", "design --phase-margin 89"),
        ("half the sample rate", "design --sample-period 1e-8"),
    ],
)
def test_an_error_is_one_line(message, arguments, stage, capsys):
    assert message in failure(capsys, *arguments.replace("STAGE", str(stage)).split())


def test_a_folder_that_cannot_be_written_is_reported_before_the_work(tmp_path, stage, capsys):
    taken = tmp_path / "file"
    taken.write_text("here already")
    assert "cannot write there" in failure(capsys, "reproduce", "--out", taken)
    assert "cannot write there" in failure(capsys, "simulate", stage, "--out", taken / "x.csv")
    assert taken.read_text() == "here already"


def test_debug_shows_the_traceback(stage):
    with pytest.raises(ValueError, match="no variable"):
        main(["simulate", str(stage), "--set", "mm=1", "--debug"])


@pytest.mark.parametrize(
    "words",
    [
        *("info FILE.fmu", "info FILE.ssp", "check FILE.fmu", "simulate FILE.fmu"),
        *("simulate FILE.ssp", "serve FILE.fmu", "export FILE.ssp --as fmu --out o"),
        *("learn FILE.csv", "learn FILE.csv --check", "validate FILE.json --log FILE.csv"),
        *("export compensator --parameters FILE.json --as c --out o", "fleet FILE.toml --out o"),
    ],
)
def test_a_file_that_is_not_there_is_called_missing_and_nothing_else(words, tmp_path, capsys):
    assert main(words.replace("FILE", str(tmp_path / "absent")).split()) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert re.fullmatch(r"stickslip: \S*absent\.\w+: No such file or directory", line), line


def test_choices_are_taken_in_any_case(capsys, tmp_path):
    (log := tmp_path / "log.csv").write_text("time,position\n0,0\n1,1\n")
    assert main(["learn", str(log), "--check", "--controller", "pi"]) != 0
    assert "controller PI: expected gains" in capsys.readouterr().err
