"""One variable of an FMU.

Source: FMI 2.0 section 2.2.7, FMI 3.0 section 2.4.7.
"""

import ctypes
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Any, Self

Scalar = float | int | bool | str | bytes
Value = Scalar | tuple[Scalar, ...]  # arrays row by row
_INTEGERS = [f"{sign}Int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "U")]
# Per FMI version and type: the function that sets it and the C type it takes.
SETTERS: dict[int, dict[str, tuple[str, Any]]] = {
    2: {
        "Real": ("fmi2SetReal", ctypes.c_double),
        "Integer": ("fmi2SetInteger", ctypes.c_int32),
        "Enumeration": ("fmi2SetInteger", ctypes.c_int32),
        "Boolean": ("fmi2SetBoolean", ctypes.c_int32),
        "String": ("fmi2SetString", ctypes.c_char_p),
    },
    3: {
        "Float32": ("fmi3SetFloat32", ctypes.c_float),
        "Float64": ("fmi3SetFloat64", ctypes.c_double),
        **{name: (f"fmi3Set{name}", getattr(ctypes, f"c_{name.lower()}")) for name in _INTEGERS},
        "Enumeration": ("fmi3SetInt64", ctypes.c_int64),
        "Boolean": ("fmi3SetBoolean", ctypes.c_bool),
        "String": ("fmi3SetString", ctypes.c_char_p),
        "Binary": ("fmi3SetBinary", ctypes.c_char_p),
        "Clock": ("fmi3SetClock", ctypes.c_bool),
    },
}
MAX_ELEMENTS = 1_000_000  # of all arrays together; each is a signal of its own
FLOATS = {"Real", "Float64", "Float32"}
NOT_NUMBERS = {"String", "Binary", "Clock"}
_PARAMETERS = ("parameter", "calculatedParameter", "structuralParameter")
_COMPUTED = ("calculated", "exact", "approx")
INITIALS: dict[tuple[str, str], tuple[str, ...]] = {
    (causality, variability): initials
    for causalities, variabilities, initials in (
        (("structuralParameter", "parameter"), ("fixed", "tunable"), ("exact",)),
        (("calculatedParameter", "local"), ("fixed", "tunable"), ("calculated", "approx")),
        (("input",), ("discrete", "continuous"), ()),
        (("output", "local"), ("constant",), ("exact",)),
        (("output", "local"), ("discrete", "continuous"), _COMPUTED),
        (("independent",), ("continuous",), ()),
    )
    for causality in causalities
    for variability in variabilities
}
"""Causality and variability -> values of ``initial``, the default first; what is not here, the
standard does not allow. Inputs have none in FMI 2.0, and only ``exact`` in FMI 3.0."""
_ELEMENT = re.compile(r"(?P<array>.+)\[(?P<indices>[0-9]+(, ?[0-9]+)*)\]")
_FAMILIES = {
    "number": ("Real", "Float64", "Float32"),
    "integer": ("Integer", *_INTEGERS),
    "enumeration": ("Enumeration",),
    "Boolean": ("Boolean",),
    "string": ("String",),
    "binary": ("Binary",),
    "clock": ("Clock",),
}
FAMILY = {name: family for family, names in _FAMILIES.items() for name in names}
"""Type of FMI or SSP -> the kind of value it holds."""
# What a value becomes without loss; a Boolean becomes 0 or 1. Every family becomes itself.
_WIDER = {"Boolean": {"integer", "number"}, "integer": {"enumeration", "number"}}
_WIDER["enumeration"] = {"integer"}


@dataclass(frozen=True)
class Variable:
    """A variable as the FMU describes it.

    Start, minimum, maximum and nominal are in ``unit``, None when the FMU gives none. ``structure``
    has for each dimension the structural parameter that sets its length, None where it is fixed.
    An element of an array has the array's name and its place there, row by row.
    """

    name: str
    reference: int
    type: str  # Real, Integer, ... of FMI 2.0 or Float64, Int32, ... of FMI 3.0
    causality: str
    variability: str
    initial: str | None = None
    unit: str | None = None  # as the FMU writes it; None when it gives none
    start: Value | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    description: str = ""
    dimensions: tuple[int, ...] = ()  # length of each; empty for a scalar
    structure: tuple[str | None, ...] = ()
    array: str | None = None
    element: int = 0
    enumeration: str | None = None  # name of its type, of an enumeration
    items: tuple[tuple[str, int], ...] = ()  # (name, number) of that type
    relative: bool = False  # whether it is a difference, to which no offset of units applies
    triggered: bool = False  # of a clock, whether it is a signal, which is 1 where the clock ticks

    @property
    def is_signal(self) -> bool:
        """Whether it can be connected and recorded: a number, Boolean or triggered clock."""
        return (self.type not in NOT_NUMBERS or self.triggered) and not self.dimensions

    @property
    def is_plain(self) -> bool:
        """Whether the kernel's loop takes it as it is: a scalar of 64-bit floating point."""
        return self.type in {"Real", "Float64"} and not self.dimensions and self.array is None

    @property
    def is_discrete(self) -> bool:
        """Whether it jumps: its values are held, never interpolated."""
        return self.type not in FLOATS or self.variability != "continuous"

    @property
    def family(self) -> str:
        """The kind of value that it holds."""
        return FAMILY[self.type]

    @cached_property
    def is_settable(self) -> bool:
        """Whether a start value can be given to it."""
        settable = {"parameter", "structuralParameter", "input"}
        given = self.causality in settable or self.initial in {"exact", "approx"}
        return given and self.variability != "constant"

    @property
    def owner(self) -> str:
        """The variable that the FMU knows: the array of an element, else the variable itself."""
        return self.array or self.name

    @property
    def size(self) -> int:
        """Number of values."""
        return math.prod(self.dimensions)

    def elements(self) -> Iterator[Self]:
        """Yield ``name[1,1]``, ``name[1,2]``, ...; of a scalar the variable itself."""
        if not self.dimensions:
            yield self
            return
        for place, indices in enumerate(product(*map(range, self.dimensions))):
            yield self._element(place, [i + 1 for i in indices])

    def at(self, indices: tuple[int, ...]) -> Self | None:
        """Return the element at these indices, which count from 1; None when there is none."""
        if len(indices) != len(self.dimensions):
            return None
        place = 0
        for i, length in zip(indices, self.dimensions, strict=True):
            if not 1 <= i <= length:
                return None
            place = place * length + i - 1
        return self._element(place, indices)

    def _element(self, place: int, indices: Sequence[int]) -> Self:
        return replace(
            self,
            name=f"{self.name}[{','.join(map(str, indices))}]",
            dimensions=(),
            structure=(),
            array=self.name,
            element=place,
            start=self.start[place] if isinstance(self.start, tuple) else None,
        )


def default_variability(version: int, kind: str, causality: str) -> str:
    """Return the variability of a variable that does not state it."""
    if version == 3 and causality in _PARAMETERS:
        return "fixed"
    return "continuous" if version == 2 or kind in FLOATS else "discrete"


def converts(family: str, wanted: str) -> bool:
    """Tell whether values of one family become those of another on a connection, without loss."""
    return wanted == family or wanted in _WIDER.get(family, ())


def parse_element(name: str) -> tuple[str, tuple[int, ...]] | None:
    """Split ``name[i,j]`` into the array's name and the indices."""
    match = _ELEMENT.fullmatch(name)
    if match is None:
        return None
    return match["array"], tuple(int(i) for i in match["indices"].split(","))
