"""The table of rules and what is written of it."""

import re
from pathlib import Path

import pytest

from stickslip import fmucheck
from stickslip.fmucheck.rules import table

ROOT = Path(fmucheck.__file__).parent.parent


def test_the_documentation_lists_every_rule():
    """``docs/check.md`` holds what ``stickslip.fmucheck.rules.table()`` returns."""
    assert table() in (ROOT / "docs" / "check.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("rule", fmucheck.RULES.values(), ids=lambda rule: rule.id)
def test_a_rule_explains_itself(rule):
    assert rule.summary.endswith(".")
    assert rule.advice
    assert rule.sections
    assert all(re.fullmatch(r"(\d(\.\d+)*)?", section) for section in rule.sections.values())
