"""A coarse start, as it is stated on the command line."""

import pytest

from stickslip.commandline.assignments import coarse_factors
from stickslip.errors import UsageError


def test_a_coarse_start_is_stated_on_the_command_line():
    assert coarse_factors(["F_c=0.7", "v_s=3"]) == {"F_c": 0.7, "v_s": 3.0}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("m=2", "expected one of F_s, F_c"),
        ("F_c=-1", "positive number"),
        ("F_c=0", "positive number"),
        ("F_c=nan", "positive number"),
        ("F_c=inf", "positive number"),
        ("F_c=much", "must be a number"),
        ("F_c", "expected NAME=VALUE"),
    ],
)
def test_a_coarse_start_that_makes_no_sense_is_refused(text, message):
    with pytest.raises(UsageError, match=f"--coarse.*{message}"):
        coarse_factors([text])
