"""The snippets of the README and of docs/ run as a reader runs them: in order, in an empty folder.

Comments that a page does not show say what a snippet needs:

    <!-- first: COMMAND -->   a command of bash before the next snippet, for what the reader has
    <!-- file: NAME -->       the next block is that file
    <!-- not run: REASON -->  the next block needs what is not here
    <!-- long: REASON -->     the next block is run with the thorough tests only

``$TUTORIAL`` is the folder in which docs/tutorial.md was followed. docs/adding.md is followed in a
copy of the sources, to which it adds one of each kind.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from tests.kept import kept

ROOT = Path(__file__).parents[2]
PAGES = [*sorted(ROOT.glob("docs/*.md")), ROOT / "README.md"]
SOURCES = ("cosim", "fmi", "fmucheck", "ga", "models")
BLOCK = re.compile(
    r"^(?: *<!-- (?P<mark>first|file|not run|long): (?P<value>.*?) -->\n)|"
    r"^(?P<fence>```|~~~)(?P<language>\w*)\n(?P<text>.*?)^(?P=fence)",
    re.S | re.M,
)
NOT_RUN = 20
"""At most so many snippets need what is not here."""


class Snippet(NamedTuple):
    """A snippet of a page, with its marks."""

    language: str
    text: str
    first: str = ""
    file: str = ""
    not_run: str = ""
    long: str = ""


def snippets(page: Path) -> Iterator[Snippet]:
    """Yield the snippets of a page."""
    marks: dict[str, str] = {}
    for found in BLOCK.finditer(page.read_text(encoding="utf-8")):
        if found["mark"]:
            marks[found["mark"].replace(" ", "_")] = found["value"]
            continue
        if found["language"] in ("bash", "python") or "file" in marks:
            yield Snippet(found["language"], found["text"], **marks)
        marks = {}


def follow(page: Path, folder: Path, *, long: bool = True, **environment: str) -> list[str]:
    """Run the snippets of a page, or those that are not long; return what each prints."""
    bin_folder = Path(sys.executable).parent
    env = {**os.environ, **environment}
    env["PATH"] = f"{bin_folder}{os.pathsep}{env['PATH']}"
    printed = []
    try:
        for one in snippets(page):
            if one.not_run or (one.long and not long):
                continue
            if one.first:
                run(["bash", "-euc", one.first], folder, env)
            if one.file:
                (folder / one.file).write_text(one.text, encoding="utf-8")
                continue
            words = [sys.executable, "-c"] if one.language == "python" else ["bash", "-euc"]
            printed.append(run([*words, one.text], folder, env))
    finally:
        for group in (folder / ".groups").read_text().split():  # what serves in the background
            with suppress(ProcessLookupError):
                os.killpg(int(group), signal.SIGTERM)
    return printed


def run(words: list[str], folder: Path, env: dict[str, str]) -> str:
    """Run a process that may leave others in the background; return what it prints."""
    with (folder / ".printed").open("w+") as output, (folder / ".groups").open("a") as groups:
        child = subprocess.Popen(
            words, cwd=folder, env=env, stdout=output, stderr=output, start_new_session=True
        )
        groups.write(f"{child.pid}\n")
        status = child.wait(timeout=600)
        output.seek(0)
        printed = output.read()
    assert status == 0, f"{words[-1]}\n{printed[-5000:]}"
    return printed


@pytest.fixture(scope="module")
def added(tmp_path_factory):
    """Return a copy of sources and tests, to which docs/adding.md has added one of each kind."""
    folder = tmp_path_factory.mktemp("clone")
    for name in (*SOURCES, "stickslip", "tests"):
        shutil.copytree(ROOT / name, folder / name)
    shutil.copy(ROOT / "pyproject.toml", folder)
    shutil.copy(ROOT / "LICENSE", folder / "stickslip")
    for name in SOURCES:
        (folder / "stickslip" / name).symlink_to(folder / name)
    follow(ROOT / "docs/adding.md", folder, PYTHONPATH=str(folder))
    return folder


@pytest.fixture(scope="module")
def tutorial():
    """Return the folder in which the tutorial was followed, and what it prints."""

    def make(folder: Path) -> tuple[str, list[str]]:
        return str(folder), follow(ROOT / "docs/tutorial.md", folder)

    return kept("tutorial", make)


@pytest.fixture(scope="module")
def printed(tutorial, tmp_path_factory):
    """Return what the snippets of a page print; each page is followed once."""
    done = {("docs/tutorial", False): tutorial[1]}

    def printed(name: str, *, long: bool = False) -> list[str]:
        if (name, long) not in done:
            page, folder = ROOT / f"{name}.md", tmp_path_factory.mktemp("page")
            done[name, long] = follow(page, folder, long=long, TUTORIAL=tutorial[0])
        return done[name, long]

    return printed


LONG = {
    f"docs/{name}"
    for name in (
        *("arena", "cosimulation", "drives", "export", "fleet", "learning", "rig", "robots"),
        "tuning",
    )
}
"""Pages whose commands learn and tune further drives, compare compensators, or export often."""
RUN = [
    str(page.relative_to(ROOT).with_suffix(""))
    for page in PAGES
    if page.stem != "adding" and any(not one.not_run for one in snippets(page))
]
MIXED = {name for name in RUN if any(one.long for one in snippets(ROOT / f"{name}.md"))}


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({*RUN} - LONG))
def test_a_page_can_be_followed(printed, name):
    printed(name)


@pytest.mark.slow
@pytest.mark.thorough
@pytest.mark.parametrize("name", sorted(LONG | MIXED))
def test_a_long_page_can_be_followed(printed, name):
    printed(name, long=True)


@pytest.mark.thorough
@pytest.mark.slow
def test_an_addition_that_fails_is_left_out_with_one_line(added):
    """All else works, and what is added runs until then."""
    broken = {
        "stickslip/logs/formats/my_format.py": "VALUES = np.zeros(3)",
        "ga/algorithms/my_search.py": "class Search(Optimiser):\n    pass",
        "models/laws/my_law/law.toml": "title = ",
        "models/compensators/my_compensator/model.toml": "[inputs",
    }
    for path, text in broken.items():
        (added / path).write_text(text)
    (added / "stickslip/commands/my_command.py").write_text('"""``stickslip my_command``: x."""\n!')
    env = {**os.environ, "PYTHONPATH": str(added)}
    use = "import stickslip as ss; print(ss.law_names(), ss.ga.ALGORITHMS, ss.models.model_names())"
    printed = run([sys.executable, "-c", f"{use}; import stickslip.logs.formats"], added, env)
    lines = [line for line in printed.splitlines() if "is left out" in line]
    assert sorted(str(Path(line.split(" is left")[0]).name) for line in lines) == sorted(
        ["my_format.py", "my_search.py", "my_law", "model.toml"]
    )
    assert len(printed.splitlines()) == len(lines) + 1
    assert "lugre" in printed
    words = [sys.executable, "-m", "stickslip", "my_command"]
    done = subprocess.run(words, cwd=added, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert done.stderr.startswith("stickslip: stickslip.commands.my_command: SyntaxError")
    assert done.stderr.count("\n") == 1


def test_few_snippets_are_not_run():
    left = [one for page in PAGES for one in snippets(page) if one.not_run]
    assert len(left) <= NOT_RUN


def test_commands_stand_in_blocks_that_are_run():
    hidden = re.compile(r"\n\n    (?:stickslip|pip|make|python3?) ")
    assert not [page.name for page in PAGES if hidden.search(page.read_text(encoding="utf-8"))]


@pytest.mark.slow
def test_the_tutorial_finds_the_values_that_it_names(tutorial):
    text = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
    names, values = re.findall(r"^\| (.*) \|$", text, flags=re.M)[:2]
    true = dict(zip(re.findall(r"(\w+) \[", names), map(float, values.split(" | ")), strict=True))
    learned = json.loads((Path(tutorial[0]) / "axis-1/learned.json").read_text())["parameters"]
    for name, value in true.items():
        found = learned[name]
        assert abs(found["value"] - value) < 3.0 * found["standard_error"]


@pytest.mark.slow
def test_the_readme_shows_the_verdict_that_is_printed(tutorial):
    """Words are equal, whatever the lines; numbers differ somewhat from processor to processor."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    [shown] = re.findall(r"^```text\n(.*?)^```", text, flags=re.S | re.M)
    assert shown.count("\n") > 10
    printed = "".join(tutorial[1])
    begin = " ".join(shown.split()[:6])  # which stands in a line
    words, numbers = _words_and_numbers(shown)
    found, measured = _words_and_numbers(printed[printed.index(begin) :])
    assert found[: len(words)] == words
    assert measured[: len(numbers)] == pytest.approx(numbers, rel=0.3)


def _words_and_numbers(text: str) -> tuple[list[str], list[float]]:
    number = r"\d+\.?\d*"
    return re.sub(number, "#", text).split(), [float(one) for one in re.findall(number, text)]


@pytest.mark.slow
def test_a_sliding_stage_follows_its_closed_form(printed):
    """Constant force and friction: m dv/dt = u - F_c - b v."""
    [velocity] = re.findall(r"([\d.]+) m/s", "".join(printed("README")))
    m, b, force = 5.557, 6.6135, 12.0 - 4.0
    assert float(velocity) == pytest.approx(force / b * (1 - np.exp(-b / m)), rel=0.01)
