"""No false alarm: what is right is found right."""

import pytest

from stickslip import fmucheck, models


@pytest.mark.parametrize("version", [2, 3])
@pytest.mark.parametrize(
    "name", [*models.model_names(), *(f"drive+{law}" for law in models.law_names())]
)
def test_our_models_are_sound(build, name, version):
    report = fmucheck.check(build(name, version))
    assert report.fmi == f"{version}.0"
    assert [f for f in report if f.severity > fmucheck.Severity.NOTE] == []
