"""A log described by a TOML file, by options, or by both."""

import argparse
from pathlib import Path

import pytest

from stickslip.commandline.log_options import add_log_options, description_of
from stickslip.errors import UsageError
from stickslip.logs import Column, Description, load_description

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
    columns={
        "time": Column("Zeit"),
        "position": Column(3),
        "force": Column("Iq", "A", 0.25, -0.1),
    },
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


def test_options_with_units():
    given = described(
        "--encoder-step", "0.1um", "--force-limit", "0.2 kN", "--rated-torque", "240mNm"
    )
    assert (given.encoder_step, given.force_limit, given.rated_torque) == (1e-7, 200.0, 0.24)


def test_another_controller_drops_the_gains_of_the_file(config):
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
            "gain K_p, but no controller; choose one with controller: P, PI, PID, cascade",
        ),
        (
            ["--rated-torque", "3N"],
            "--rated-torque = 3N: expected a number, with a unit such as N.m",
        ),
        (["--encoder-step", "3e-7 furlong"], "such as m, cm, mm, rad"),
        (["--span", "3", "2"], "begin before end"),
        (["--config", "none.toml"], "none.toml: cannot be read"),
    ],
)
def test_wrong_options(arguments, message):
    with pytest.raises(UsageError) as caught:
        described(*arguments)
    assert message in str(caught.value)
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
