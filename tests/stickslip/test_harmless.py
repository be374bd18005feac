"""No text of an untrusted file moves the cursor of a terminal or turns the direction of a page."""

import re

import pytest

from stickslip.cli import main
from stickslip.contents import info
from stickslip.presentation.markup import text
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
        ("info",),
        ("info", "--all"),
        ("simulate",),
        ("simulate", "--verbose"),
        ("simulate", "--set", "k=99"),
        ("simulate", "--record", "none"),
        ("check", "--no-run"),
    ],
    ids=" ".join,
)
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
