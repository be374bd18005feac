"""What every rule says of itself."""

import re

import pytest

from stickslip import fmucheck


@pytest.mark.parametrize("rule", fmucheck.RULES.values(), ids=lambda rule: rule.id)
def test_a_rule_explains_itself(rule):
    assert rule.summary.endswith(".")
    assert rule.advice
    assert rule.sections
    assert all(re.fullmatch(r"(\d(\.\d+)*)?", section) for section in rule.sections.values())
