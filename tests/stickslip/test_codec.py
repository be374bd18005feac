"""Dataclasses are written as plain data with units, and read again."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.models.export.units import motion_unit
from stickslip.servo.measurement import Array
from stickslip.storage.codec import decode, encode, entry, state, units


@dataclass(frozen=True)
class Part:
    size: float = field(metadata=entry("m"))
    name: str = ""
    remark: str = field(default="none", metadata=entry(stored=False))


@dataclass(frozen=True)
class Whole:
    parts: Mapping[str, Part]
    order: tuple[str, ...]
    force: float = field(metadata=entry("N", key="F"))
    best: Part | None = None


@dataclass(frozen=True, eq=False)
class Signal:
    t: Array = field(metadata=entry("s"))


WHOLE = Whole({"a": Part(1e-6, "left")}, ("a",), 2.5, Part(math.nan))
PLAIN = {
    "parts": {"a": {"size": {"value": 1e-6, "unit": "m"}, "name": "left"}},
    "order": ["a"],
    "F": {"value": 2.5, "unit": "N"},
    "best": {"size": {"value": None, "unit": "m"}, "name": ""},
}


def test_fields_have_the_units_and_names_that_they_state():
    assert encode(WHOLE) == PLAIN
    assert units(Whole) == {"F": "N"}
    turned = encode(WHOLE, lambda unit: motion_unit(unit, rotary=True))
    assert [turned["F"]["unit"], turned["parts"]["a"]["size"]["unit"]] == ["N.m", "rad"]
    assert state({"m": True}, {"m": "kg"}) == {"m": {"value": 1.0, "unit": "kg"}}


names = st.text(min_size=1)
parts = st.builds(Part, st.floats(allow_nan=False, allow_infinity=False), st.text())
wholes = st.builds(
    Whole,
    st.dictionaries(names, parts),
    st.lists(names).map(tuple),
    st.floats(allow_nan=False, allow_infinity=False),
    st.none() | parts,
)


@given(wholes)
def test_what_is_written_is_read_again(whole):
    assert decode(Whole, json.loads(json.dumps(encode(whole), allow_nan=False))) == whole


def test_arrays_are_lists():
    written = encode(Signal(np.array([0.0, np.inf])))
    assert written == {"t": {"value": [0.0, None], "unit": "s"}}
    np.testing.assert_array_equal(decode(Signal, written).t, [0.0, np.nan])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"F": {"value": 1.0, "unit": "kN"}}, "Whole.F: expected a value in N, got .*kN"),
        ({"F": 1.0}, "Whole.F: expected a value in N, got 1.0"),
        ({"F": {"value": "1", "unit": "N"}}, "Whole.F: expected float, got '1'"),
        ({"order": 1}, "Whole.order: expected tuple, got 1"),
        ({"parts": {"a": {"name": ""}}}, r"Whole.parts.a: 'size' is missing"),
        ({"parts": {"a": 3}}, r"Whole.parts.a: expected names, got 3"),
    ],
)
def test_what_is_of_another_kind_is_named(change, message):
    with pytest.raises(ValueError, match=message):
        decode(Whole, PLAIN | change)
