"""Messages name settings as their reader knows them, and no untrusted text moves a terminal."""

import re
from dataclasses import fields
from inspect import signature
from pathlib import Path

import pytest

import stickslip as ss
from stickslip import cli, errors
from stickslip.cli import main
from stickslip.contents import info
from stickslip.errors import UsageError, settings_as_options
from stickslip.logs.recording import Finding
from stickslip.presentation.markup import text
from stickslip.studies.arena.comparison import make_plan
from tests.corpus.hostile.sound import describe, replaced
from tests.corpus.hostile.zips import zipped

ODD = "\u202e", "\u2066", "\u200f", "\u061c", "\x7f", "\x85", "\ufeff", "\U000e0001"
SEEN = "\u00a0\u202f\u2009\u00b5\u4e2d"
HARM = re.compile(f"[{''.join(ODD)}]")


@pytest.fixture
def odd(tmp_path):
    """Return an FMU in whose names, units and texts are characters that are not seen."""
    mark = "".join(ODD) + SEEN
    pairs = [
        ('name="u"', f'name="u{mark}"'),
        ('name="y"', f'name="y{mark}"'),
        ('modelName="reference"', f'modelName="r{mark}"'),
        ('description="Rate"', f'description="{mark}"'),
    ]
    text = re.sub(r'unit="m/s"|Unit name="m/s"', lambda m: m[0][:-1] + mark + '"', _plain(pairs))
    path = tmp_path / f"a{ODD[0]}.fmu"
    path.write_bytes(zipped(describe(text.encode())))
    return path


def _plain(pairs):
    return replaced(2, *(pair for pair in pairs if pair[0] in replaced(2).decode())).decode()


@pytest.mark.parametrize(
    "arguments",
    [
        ("info",), ("info", "--all"), ("simulate",), ("simulate", "--verbose"),
        ("simulate", "--set", "k=99"), ("simulate", "--record", "none"), ("check", "--no-run"),
    ],
    ids=" ".join,
)  # fmt: skip
def test_nothing_that_is_not_seen_is_printed(odd, arguments, capsys):
    main([arguments[0], str(odd), *arguments[1:]])
    out, err = capsys.readouterr()
    assert not HARM.search(out + err)
    assert "\\u202e" in out + err


def test_a_log_and_a_folder_of_results_are_printed_harmless(tmp_path, capsys):
    log = tmp_path / f"a{ODD[0]}.csv"
    log.write_text(f"time,{ODD[0]}x,b{ODD[4]}\n" + "0,1,x\n" * 30, encoding="utf-8")
    assert main(["learn", str(log), "--check"])
    assert main(["simulate", str(log)])
    assert main(["verify", str(tmp_path / ODD[1])])
    assert not HARM.search("".join(capsys.readouterr()))


def test_pages_and_notebooks_show_escapes(odd):
    page = info(odd)._repr_html_()
    assert "\\u202e" in page
    assert not HARM.search(page)
    assert text(f"a{ODD[0]}{SEEN}<b>") == f"a\\u202e{SEEN}&lt;b&gt;"


ROOMS = (
    *("logs", "identification", "rigs", "servo", "trial", "storage", "evaluation", "presentation"),
    *("tuning", "catalog", "compensators", "learned", "work", "planning", "loops"),
)
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
        ("continue with <resume>", "continue with --resume", "continue with resume=True"),
        ("another <out>", "another folder with --out", "another folder"),
        ("<unit> <b> <>", "--unit <b> <>", "unit <b> <>"),
    ],
)
def test_a_setting_is_an_option_or_a_keyword(text, option, keyword):
    assert str(UsageError(text)) == Finding("note", text).what == keyword
    with settings_as_options():
        assert str(UsageError(text)) == Finding("note", "", advice=text).advice == option


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("give <column time=NAME>", "give NAME in the field 'time'"),
        ("<unit force=mN> or <gain>", "mN in the field 'unit' of 'force' or the field"),
        (
            "<unit time=ms force=kN>",
            "ms in the field 'unit' of 'time', kN in the field 'unit' of 'force'",
        ),
        ("give <law auto>", "give auto in the field 'Friction law'"),
    ],
)
def test_a_setting_is_a_field_in_the_workbench(monkeypatch, text, field):
    monkeypatch.setenv(errors._STYLE, "fields")
    assert field in str(UsageError(text))


def test_every_setting_is_one_of_both():
    names = re.search(r"<\((.*?)\)", errors._SETTING.pattern)[1].split("|")
    keywords = {one.name for kind in (ss.Description, ss.LearnSettings) for one in fields(kind)}
    for function in (ss.simulate, ss.tune, ss.arena, make_plan, ss.write_learned):
        keywords |= {*signature(function).parameters}
    called = {errors._OTHERWISE.get(name, name).partition("=")[0] for name in names}
    assert not called - keywords - {"column", "unit", "scale"}
    options = set[str]()
    for command in ("learn", "simulate", "tune", "arena"):
        parser = cli._parser([command])._subparsers._group_actions[0].choices[command]
        options |= {*parser._option_string_actions}
    assert not {f"--{name.replace('_', '-')}" for name in names} - options


def test_no_message_of_python_names_an_option():
    """But for those of a whole command, such as 'stickslip plan --show F_s'."""
    wrong = {}
    for path in (path for room in ROOMS for path in (SOURCES / room).rglob("*.py")):
        text = re.sub(r'""".*?"""', "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        text = re.sub(r"stickslip [a-z]+( \w+\.json)? --[a-z]+", "", text)
        wrong[path.name] = re.findall(r"--[a-z]\w+", text)
    assert len(wrong) > 70
    assert not any(wrong.values()), wrong
