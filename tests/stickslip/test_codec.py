"""Dataclasses are written as plain data with units."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from stickslip.models.export.units import motion_unit
from stickslip.servo.measurement import Array
from stickslip.storage.codec import encode, entry, state, units


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


def test_arrays_are_lists():
    written = encode(Signal(np.array([0.0, np.inf])))
    assert written == {"t": {"value": [0.0, None], "unit": "s"}}
