"""No false alarm: what is right is found right."""

from itertools import cycle, product

import pytest

from stickslip import fmucheck, models

LAWS = [f"drive+{law}" for law in models.law_names()]


@pytest.mark.parametrize(
    ("name", "version"),
    [
        *product(models.model_names(), (2, 3)),
        *zip(LAWS, cycle((2, 3))),  # what has a version is the same for all laws
    ],
)
def test_our_models_are_sound(build, name, version):
    report = fmucheck.check(build(name, version))
    assert report.fmi == f"{version}.0"
    assert [f for f in report if f.severity > fmucheck.Severity.NOTE] == []
