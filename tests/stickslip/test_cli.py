"""The command line: results, and one clear line for each error."""

import json
import os
import re
import subprocess
import sys
import zipfile
from importlib.metadata import version

import numpy as np
import pandas as pd
import pytest

import stickslip as ss
from stickslip import models
from stickslip.cli import COMMANDS, main

LARGE = {"control", "fmpy", "matplotlib", "pandas", "scipy.linalg"}
"""Libraries that take seconds to load."""


def complaint(capsys, *arguments) -> str:
    """Return the one line that a failing command prints."""
    assert main([str(a) for a in arguments]) == 1
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("stickslip: ")
    return lines[0]


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
        ("simulate --re", {"--real-time", "--record", "--resume"}),
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


def test_a_library_that_is_missing_is_named_before_the_run(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("stickslip.commands.simulate.find_spec", lambda _: None)
    for out, extra in (("a.xlsx", "excel"), ("a.parquet", "parquet")):
        line = complaint(capsys, "simulate", tmp_path / "none.fmu", "--out", tmp_path / out)
        assert f"pip install 'stickslip[{extra}]'" in line


def test_build_makes_both_versions_of_all_models(tmp_path, capsys):
    assert main(["build", "--out", str(tmp_path)]) == 0
    assert len(capsys.readouterr().out.split()) == 2 * len(models.model_names())
    assert (tmp_path / "fmi3" / "drive.fmu").exists()


def test_build_takes_a_friction_law(tmp_path):
    assert main(["build", "drive", "--law", "gms", "--fmi", "3", "--out", str(tmp_path)]) == 0
    described = zipfile.ZipFile(tmp_path / "drive.fmu").read("modelDescription.xml").decode()
    assert 'name="F_e[4]"' in described
    everything = ["build", "--law", "dahl", "--fmi", "2", "--out", str(tmp_path / "all")]
    assert main(everything) == 0
    built = {path.stem for path in (tmp_path / "all").iterdir()}
    assert built == {name for name in models.model_names() if models.load_model(name).law}


def test_simulate_sets_values_takes_input_and_records(stage, tmp_path, capsys):
    force = tmp_path / "force.csv"
    force.write_text("time,u\n0,0\n1,50\n")
    out = tmp_path / "out.csv"
    arguments = ["simulate", stage, "--input", force, "--stop", 1, "--set", "m=2.0", "stage.b=0"]
    assert main([str(a) for a in [*arguments, "--record", "v", "--out", out]]) == 0
    run = pd.read_csv(out)
    assert list(run.columns) == ["time", "stage.v"]
    # Far above friction, m v = integral of (u - F_c).
    assert run["stage.v"].iloc[-1] == pytest.approx((25 - 5.999) / 2.0, rel=0.1)
    assert "m/s" in capsys.readouterr().out


def test_design_prints_what_was_asked_for(tmp_path, capsys):
    arguments = ["design", "--bandwidth", "80", "--phase-margin", "55", "--out", str(tmp_path)]
    assert main(arguments) == 0
    design = json.loads((tmp_path / "design.json").read_text())
    assert design["crossover_Hz"] == pytest.approx(80, rel=1e-6)
    assert design["phase_margin_deg"] == pytest.approx(55, rel=1e-6)
    assert "K_p" in capsys.readouterr().out


@pytest.mark.slow
def test_export_takes_what_was_learned_in_each_form(results, tmp_path, capsys):
    learned = json.loads((results / "learned.json").read_text())["parameters"]["F_c"]["value"]
    for form, names in {"fmu": ["fmu"], "c": ["h", "c"], "st": ["st"]}.items():
        arguments = ["--parameters", results / "learned.json", "--as", form, "--out", tmp_path]
        assert main(["export", "compensator", "--force", *map(str, arguments)]) == 0
        written = [tmp_path / f"compensator.{name}" for name in names]
        assert capsys.readouterr().out.split() == [str(path) for path in written]
        if form == "fmu":
            assert written[0].read_bytes() == (results / "compensator.fmu").read_bytes()
        else:
            assert repr(learned) in written[-1].read_text()


def test_export_makes_an_fmu_of_a_linear_system(tmp_path, capsys):
    file = tmp_path / "lag.toml"
    file.write_text('num = [2.0]\nden = [0.5, 1.0]\ninputs = { u = "N" }\noutputs = { y = "m" }')
    assert main(["export", "lti", str(file), "--fmi", "3", "--out", str(tmp_path)]) == 0
    fmu = tmp_path / "lag.fmu"
    assert capsys.readouterr().out.split() == [str(fmu)]
    run = ss.simulate(fmu, parameters={"u": 3.0}, stop=1.0, step=0.1)
    assert run["lag.y"] == pytest.approx(6 * (1 - np.exp(-2 * run.time)))


@pytest.mark.slow
def test_validate_evaluates_given_parameters_on_a_given_drive(results, tmp_path, capsys):
    learned = str(results / "learned.json")
    arguments = ["validate", "--parameters", learned, "--out", str(tmp_path)]
    assert main(arguments) == 0
    same = pd.read_csv(tmp_path / "table4.csv")
    expected = pd.read_csv(results / "table4.csv")
    assert same["with"].to_numpy() == pytest.approx(expected["with"].to_numpy(), rel=1e-12)
    assert main([*arguments, "--set", "drive.F_c=3"]) == 0
    other = pd.read_csv(tmp_path / "table4.csv")
    assert (other["with"] > 3 * expected["with"]).all()  # the wrong friction is compensated
    assert "E_rms" in capsys.readouterr().out
    assert main([*arguments, "--velocity-filter"]) == 0
    assert (pd.read_csv(tmp_path / "table4.csv").reduction > 0.95).all()


@pytest.mark.parametrize(
    ("message", "arguments"),
    [
        ("there is no model 'stag'", "build stag"),
        ("no friction law 'ghost'", "build --law ghost"),
        ("'nominal_loop' contains no friction law", "build nominal_loop --law gms"),
        ("no variable 'mm'", "simulate STAGE --set mm=1"),
        ("outside", "simulate STAGE --set m=-1"),
        ("foo", "simulate STAGE --record foo"),
        ("every = 0", "simulate STAGE --every 0"),
        ("does not divide", "simulate STAGE --stop 0.1001"),
        ("No such file", "simulate none.fmu"),
        ("expected a file", "simulate loop.xml"),
        ("expected a file .ssp or .fmu", "info a.xml"),
        ("out of reach", "design --phase-margin 89"),
        ("half the sample rate", "design --sample-period 1e-8"),
        ("No such file", "export lti none.json"),
        ("expected a .json or .toml", "export lti a.mat"),
    ],
)
def test_an_error_is_one_line(message, arguments, stage, capsys):
    assert message in complaint(capsys, *arguments.replace("STAGE", str(stage)).split())


def test_a_folder_that_cannot_be_written_is_reported_before_the_work(tmp_path, stage, capsys):
    taken = tmp_path / "file"
    taken.write_text("here already")
    assert "cannot write there" in complaint(capsys, "reproduce", "--out", taken)
    assert "cannot write there" in complaint(capsys, "simulate", stage, "--out", taken / "x.csv")
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
