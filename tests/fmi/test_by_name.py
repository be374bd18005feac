"""Values by name, as dictionaries and as what pandas has."""

from __future__ import annotations

from collections import namedtuple
from types import MappingProxyType

import pandas as pd
import pytest

from stickslip.fmi.by_name import by_name
from stickslip.fmi.errors import Fault

TABLE = pd.DataFrame({"F_c": [1.0, 2.0], "n": [3, 4]})
DOTTED = pd.DataFrame({"stage.m": [1.0]})
Pair = namedtuple("Pair", "F_c n")


@pytest.mark.parametrize(
    "given",
    [
        {"F_c": 2.0, "n": 4},
        MappingProxyType({"F_c": 2.0, "n": 4}),
        TABLE.iloc[1],
        TABLE.loc[[1]],
        list(TABLE.itertuples())[1],
        list(TABLE.itertuples(index=False))[1],
        Pair(2.0, 4),
    ],
)
def test_a_row_is_a_dictionary(given):
    assert by_name("parameters", given, Fault) == {"F_c": 2.0, "n": 4}


def test_a_row_of_a_frame_keeps_the_types_of_its_columns():
    assert isinstance(by_name("parameters", TABLE.loc[[1]], Fault)["n"].item(), int)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (TABLE, r"one row, got one of 2; see table\.iloc\[0\]"),
        (next(DOTTED.itertuples()), r"itertuples called a column _1, .*table\.iloc\[0\]"),
        (TABLE["F_c"], r"expected each by its name, as \{'name': \.\.\.\}, got 0"),
        ({1: 2.0}, r"expected each by its name, .*got 1$"),
        ([("F_c", 1.0)], r"expected a dictionary with a name for each, got \[\('F_c', 1\.0\)\]"),
        ("F_c=1", "expected a dictionary with a name for each, got 'F_c=1'"),
        (pd.Series([1.0, 2.0], ["m", "m"]), "a name comes twice: m, m"),
    ],
)
def test_what_has_no_names_ends_in_one_line(given, message):
    with pytest.raises(Fault, match=f"^parameters: .*{message}") as told:
        by_name("parameters", given, Fault)
    assert "\n" not in str(told.value)
