"""The documents: the index of decisions, links, and words that were replaced."""

import re
import shlex
from pathlib import Path

import pytest

from stickslip import cli
from stickslip.thresholds import harm, misfit

ROOT = Path(__file__).parents[1]
DECISIONS = sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))
DOCUMENTS = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "models").rglob("*.md")]
WRITTEN = [path for path in DOCUMENTS if path.name != "check-defects.md"]  # it quotes names
REPLACED = (
    *("judge", "judges", "judged", "stranger", "strangers", "fed", "lest", "anew", "mute"),
    *("replica", "replicas", "valley", "valleys", "stand-in", "facade", "knock", "foretell"),
    *("weakly known", "well known", "not visible", "laid flat", "is none of", "stick force"),
)


def name(path: Path) -> str:
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", DECISIONS, ids=name)
def test_a_decision_has_its_parts_and_is_in_the_index(path):
    text = path.read_text(encoding="utf-8")
    heading = re.match(r"# (\d+)\. (.+)\n", text)
    assert heading, "expected a first line '# NUMBER. TITLE'"
    number, title = heading.groups()
    assert path.name.startswith(f"{int(number):04d}-")
    status = re.search(
        r"^Status: (accepted|(?:changed|superseded) by .+?), \d{4}-\d\d-\d\d", text, re.MULTILINE
    )
    assert status, "expected 'Status: accepted|changed by ...|superseded by ..., YEAR-MONTH-DAY'"
    index = (path.parent / "README.md").read_text(encoding="utf-8")
    rows = [row.split(" | ") for row in index.splitlines() if row.startswith(f"| [{number}](")]
    assert len(rows) == 1, f"expected one row for decision {number} in docs/decisions/README.md"
    [[first, *_, last]] = rows
    assert first == f"| [{number}]({path.name})"
    assert rows[0][1] == title
    assert last.removesuffix(" |") == status[1]
    headings = re.findall(r"^## (.+)$", text, re.MULTILINE)
    allowed = ["Context", "Decision", "Consequences", "Alternatives tried"]
    assert headings[:2] == allowed[:2]
    assert headings == [heading for heading in allowed if heading in headings]


def test_relative_links_lead_to_files():
    link = re.compile(r"(?<!\\)\]\(([^)#\s]+)(?:#[^)]*)?\)")
    missing = [
        f"{name(path)}: {target}"
        for path in DOCUMENTS
        for target in link.findall(path.read_text(encoding="utf-8"))
        if ":" not in target and not (path.parent / target).exists()
    ]
    assert not missing


def test_no_replaced_word():
    pattern = rf"\b({'|'.join(REPLACED)})\b"
    found = {
        f"{name(path)}, line {number}: {match[0]}"
        for path in WRITTEN
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if not line.startswith("    ")  # what a command prints
        for match in re.finditer(pattern, re.sub(r"`[^`]*`", "", line), re.IGNORECASE)
    }
    assert not found


def test_commands_are_accepted(capsys):
    """Every command in a block has words that the command line knows."""
    refused, tried = [], 0
    for path in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]:
        text = path.read_text(encoding="utf-8").replace("\\\n", "")
        blocks = "".join(re.findall(r"^```bash\n(.*?)^```", text, re.MULTILINE | re.DOTALL))
        for line in re.findall(r"^(?:\.venv/bin/)?stickslip (.+)$", blocks, re.MULTILINE):
            if "my_" in line:  # what the reader adds
                continue
            words = shlex.split(line, comments=True)
            tried += 1
            try:
                cli._parser(words).parse_args(words)
            except SystemExit:
                refused.append(f"{name(path)}: stickslip {line}: {capsys.readouterr().err}")
    assert tried > 30
    assert not refused


@pytest.mark.parametrize(
    ("page", "told"),
    [
        ("learning-output.md", harm.rule()),
        (
            "results.md",
            f"more than {misfit.EXPLAINED:g} times what noise and encoder steps explain",
        ),
        ("results.md", f"at most {misfit.NOTED:g} times what noise and encoder steps explain"),
    ],
)
def test_a_rule_is_told_with_the_numbers_that_decide(page, told):
    assert told in (ROOT / "docs" / page).read_text(encoding="utf-8")
