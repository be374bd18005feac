"""Messages name settings as keywords in Python, and as options in commands."""

import re
from dataclasses import fields
from pathlib import Path

import pytest

import stickslip as ss
from stickslip import cli, errors
from stickslip.errors import UsageError, settings_as_options
from stickslip.logs.recording import Finding

ROOMS = ("logs", "identification", "rigs", "servo", "trial")
SOURCES = Path(errors.__file__).parent


@pytest.mark.parametrize(
    ("text", "option", "keyword"),
    [
        ("<sample_period>", "--sample-period", "sample_period"),
        ("<sample_period 1e-3>", "--sample-period 1e-3", "sample_period=1e-3"),
        ("<law auto>", "--law auto", 'law="auto"'),
        ("<span 1.5 2>", "--span 1.5 2", "span=(1.5, 2,)"),
        ("<confirm mass>", "--confirm mass", 'confirm=("mass",)'),
        ("<unit time=ms>", "--unit time=ms", 'columns={"time": Column(unit="ms")}'),
        ("<column time=NAME>", "--column time=NAME", 'columns={"time": Column(name=NAME)}'),
        (
            "<scale force=2*-1 time=3>",
            "--scale force=2*-1 time=3",
            'columns={"force": Column(scale="2*-1"), "time": Column(scale=3)}',
        ),
        ("<unit> <b> <>", "--unit <b> <>", "unit <b> <>"),
    ],
)
def test_a_setting_is_an_option_or_a_keyword(text, option, keyword):
    assert str(UsageError(text)) == Finding("note", text).what == keyword
    with settings_as_options():
        assert str(UsageError(text)) == Finding("note", "", advice=text).advice == option


def test_every_setting_is_one_of_both():
    names = re.search(r"<\((.*?)\)", errors._SETTING.pattern)[1].split("|")
    keywords = {one.name for kind in (ss.Description, ss.LearnSettings) for one in fields(kind)}
    assert not {*names} - keywords - {"column", "unit", "scale"}
    learn = cli._parser(["learn"])._subparsers._group_actions[0].choices["learn"]
    assert not {f"--{name.replace('_', '-')}" for name in names} - {*learn._option_string_actions}


def test_no_message_of_python_names_an_option():
    """But for those of a whole command, such as 'stickslip plan --show F_s'."""
    wrong = {}
    for path in (path for room in ROOMS for path in (SOURCES / room).rglob("*.py")):
        text = re.sub(r'""".*?"""', "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        wrong[path.name] = re.findall(r"(?<!stickslip \w{4} )(?<!stickslip \w{5} )--[a-z]\w+", text)
    assert len(wrong) > 70
    assert not any(wrong.values()), wrong
