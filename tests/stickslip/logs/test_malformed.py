"""Faults of a log and of its description are reported in one line; see tests/corpus/hostile."""

import argparse
import io
import re
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from stickslip import models
from stickslip.commandline.log_options import add_log_options, description_of
from stickslip.errors import RecordingError, UsageError
from stickslip.logs import Column, Controller, Description, load_description

ROWS = [f"{k * 0.001:.3f},{np.sin(k / 50):.9f},{np.cos(k / 50):.9f}" for k in range(100)]


def csv(*, header="t,x,F", **changed: str) -> bytes:
    """Return a log of 100 rows; ``row_7="..."`` puts a text into that row of the file."""
    lines = [header, *ROWS]
    for key, text in changed.items():
        lines[int(key.removeprefix("row_")) - 1] = text
    return "\n".join(lines).encode()


def mat(content) -> bytes:
    stream = io.BytesIO()
    scipy.io.savemat(stream, content)
    return stream.getvalue()


T, X = np.arange(50) * 1e-3, np.linspace(0, 1, 50)

FILES = {
    "time hardly moves": (csv(row_40="0.03700000000001,1,2"), "row 40", "time moves by 1e-14 s"),
    "nanoseconds as s": (csv().replace(b"t,x", b"time [ns],x"), "sample period of 1e-12 s"),
    "time not finite": (csv(row_9="nan,1,2"), "row 9", "nan"),
    "huge": (csv(row_12="0.010,1e300,2"), "'x'", "row 12", "1e+300"),
    "an empty column": (csv(**{f"row_{k}": f"{k},,1" for k in range(2, 102)}), "position: no"),
    "no time": (csv(header="a,x,F"), "no column of time", "Column(name=NAME)", "a, x, F"),
    "no header": (csv(header=ROWS[0], row_2="0.0005,0,1"), "no column of time"),
    "unknown unit": (csv(header="t,x [furlong],F"), "'x'", "'furlong'", "Column(unit="),
    "counts without scale": (csv(header="t,x [counts],F"), "is in counts", "encoder_step"),
    "wrong delimiter": (csv().replace(b",", b":"), "no row of numbers", "'0.099:"),
    "mat without vectors": (mat({"kp": 3.0, "name": "axis"}), "no vectors", "kp, name"),
    "mat of unequal lengths": (mat({"t": T, "x": X[:40]}), "'x'", "40 values", "'t'", "50"),
    "mat with text for x": (mat({"t": T, "x": "abc"}), "no column of position"),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_a_malformed_file_is_reported_in_one_line(name, read_log):
    content, *parts = FILES[name]
    with pytest.raises((RecordingError, UsageError)) as caught:
        read_log(content, name="log.bin")
    message = str(caught.value)
    assert "\n" not in message
    assert all(part in message for part in parts)


DESCRIPTIONS = {
    "column beyond": ({"columns": {"position": Column(7)}}, "no column 7, there are 3"),
    "column twice": ({"columns": {"position": Column("x"), "force": Column("x")}}, "cannot be"),
    "unit": ({"columns": {"position": Column("x", "parsec")}}, "unit 'parsec' of position"),
    "motion": ({"motion": "linear", "columns": {"position": Column("x", "deg")}}, "Column(scale="),
    "scalar": (
        {"columns": {"force": Column("F", "V", "gtau")}},
        "in SI units, or a scalar of the file, got 'gtau'",
    ),
    "no product": (
        {"columns": {"force": Column("F", "V", "2+3")}},
        "in SI units, or a scalar of the file, got '2+3'",
    ),
    "scale 0": ({"columns": {"force": Column("F", scale=0)}}, "other than 0"),
    "span": ({"span": (5.0, 6.0)}, "no samples there; the log has 0 to 0.099 s"),
    "step": ({"encoder_step": -1.0}, "encoder_step = -1"),
    "gain": ({"controller": "PI", "gains": {"K_p": "x", "K_i": 1.0}}, "gain K_p = x"),
    "no motion": ({"motion": "sideways"}, "linear or rotary"),
    "few": ({"controller": "PI", "gains": {"K_p": 1}}, "expected gains I_x and P_x or K_i and K_p"),
    "more": ({"controller": "P-P", "gains": {"K_x": 1, "K_p": 1, "P_x": 2}}, "got K_p, K_x, P_x"),
    "name": ({"gains": {"Kp": 1}}, "did you mean"),
    "delimiter": ({"delimiter": "ab"}, "one character"),
    "decimal": ({"decimal": ";"}, "expected . or ,"),
}


@pytest.mark.parametrize("name", DESCRIPTIONS)
def test_a_description_that_does_not_suit_the_file(name, read_log):
    given, message = DESCRIPTIONS[name]
    with pytest.raises((RecordingError, UsageError), match=re.escape(message)) as caught:
        read_log(csv(), Description(**given))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("columns = 3", "expected a table"),
        ("[columns.position]\nnam = 'x'", "did you mean 'name'"),
        ("[columns]\nposition = {index = 0}", "a number from 1"),
        ("[columns]\nposition = {name = 'x', index = 1}", "got both"),
        ("span = [1, 2, 3]", "[begin, end]"),
        ("[controller]\nK_p = 3", "controller '': expected one of P"),
        ("[controller]\nkind = 'P'\nK_p = [3]", "controller.K_p"),
    ],
)
def test_a_toml_file_that_is_wrong(text, message, tmp_path):
    path = tmp_path / "log.toml"
    path.write_text(text)
    with pytest.raises(UsageError, match=re.escape(message)) as caught:
        load_description(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_a_controller_sets_all_gains_of_its_fmu():
    """Missing gains are 0, whatever the FMU starts with; unknown T_s and u_max are not set."""
    given = Controller("cascade", K_x=5.0, K_p=2.0, tau_f=1e-3).parameters()
    names = {variable.name for variable in models.load_model("velocity_controller").variables}
    assert set(given) <= names
    assert given == {"K_x": 5.0, "P_x": 0.0, "I_x": 0.0, "K_p": 2.0, "K_i": 0.0, "tau_f": 1e-3}
    assert Controller("P", K_p=1.0, T_s=1e-3, u_max=9.0).parameters()["u_max"] == 9.0
    assert Controller().parameters() is None


TOML = """
motion = "rotary"
encoder_step = "2*pulse"
force_limit = 4.5
sample_period = 0.001
span = [1, 9.5]
tau_i = 1e-4
confirm = ["mass"]
delimiter = ";"
decimal = ","

[columns]
time = "Zeit"
position = 3
[columns.force]
name = "Iq"
unit = "A"
scale = 0.25
offset = -0.1

[controller]
kind = "cascade"
K_x = "kp"
K_p = 12
K_i = 3.5
u_max = 5
"""
WHOLE = Description(
    columns={"time": Column("Zeit"), "position": Column(3), "force": Column("Iq", "A", 0.25, -0.1)},
    motion="rotary",
    controller="cascade",
    gains={"K_x": "kp", "K_p": 12.0, "K_i": 3.5, "u_max": 5.0},
    encoder_step="2*pulse",
    force_limit=4.5,
    sample_period=1e-3,
    span=(1.0, 9.5),
    tau_i=1e-4,
    confirm=("mass",),
    delimiter=";",
    decimal=",",
)


@pytest.fixture
def config(tmp_path):
    path = tmp_path / "log.toml"
    path.write_text(TOML)
    return path


def described(*arguments) -> Description:
    parser = argparse.ArgumentParser()
    add_log_options(parser)
    return description_of(parser.parse_args([str(a) for a in arguments]))


def test_every_key_of_the_file(config):
    assert load_description(config) == WHOLE
    assert described("--config", config) == WHOLE
    assert described() == Description()


def test_options_go_before_the_file(config):
    given = described(
        "--config", config, "--column", "position=phi", "velocity=none", "--unit", "position=deg",
        "--scale", "force=gtau*2", "--span", 2, 3, "--motion", "linear", "--gain", "K_p=7",
        "--force-limit", 3, "--encoder-step", "1e-6", "--delimiter", "\\t", "--tau-i", 0,
    )  # fmt: skip
    assert given.columns["position"] == Column("phi", "deg")
    assert given.columns["velocity"] == Column("none")
    assert given.columns["force"] == Column("Iq", "A", "gtau*2", -0.1)
    assert given.span == (2.0, 3.0)
    assert given.motion == "linear"
    assert given.gains == {"K_x": "kp", "K_p": "7", "K_i": 3.5, "u_max": 5.0}
    assert (given.force_limit, given.encoder_step) == ("3", "1e-6")
    assert (given.delimiter, given.tau_i) == ("\t", 0.0)
    assert given.sample_period == WHOLE.sample_period
    given = described("--encoder-step", "0.1um", "--rated-torque", "240mNm")
    assert (given.encoder_step, given.rated_torque) == (1e-7, 0.24)
    # another controller drops the gains of the file
    given = described("--config", config, "--controller", "PI", "--gain", "K_p=7", "K_i=2")
    assert given.gains == {"K_p": "7", "K_i": "2"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--column", "position"], "expected NAME=VALUE"),
        (["--column", "pos=x"], "did you mean 'position'"),
        (["--unit", "force=N", "force=A"], "set twice"),
        (["--controller", "PI", "--gain", "K_d=3"], "no 'K_d'"),
        (
            ["--gain", "K_p=3"],
            "no controller; choose one with controller: P, PI, PID, cascade, P-PI",
        ),
        (["--rated-torque", "3N"], "--rated-torque = 3N: expected a number, with a unit such as"),
        (["--encoder-step", "3e-7 furlong"], "such as m, cm, mm, rad"),
        (["--span", "3", "2"], "begin before end"),
        (["--config", "none.toml"], "none.toml: cannot be read"),
    ],
)
def test_wrong_options(arguments, message):
    with pytest.raises(UsageError, match=re.escape(message)) as caught:
        described(*arguments)
    assert "\n" not in str(caught.value)


def test_the_documented_file_is_valid(tmp_path):
    text = (Path(__file__).resolve().parents[3] / "docs" / "logs.md").read_text(encoding="utf-8")
    path = tmp_path / "log.toml"
    path.write_text(text.split("```toml\n")[1].split("```")[0], encoding="utf-8")
    assert load_description(path).columns["force"] == Column(3, "A", 23.0)
    parser = argparse.ArgumentParser()
    add_log_options(parser)
    for option in parser._option_string_actions:
        assert option in text or option in ("-h", "--help"), option
