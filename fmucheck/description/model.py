"""The content of a description as plain data, which is sent to the child process."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

FLOATS = {"Real": None, "Float64": None, "Float32": None}
RANGES = {
    "Integer": (-(2**31), 2**31 - 1),
    "Enumeration": (-(2**63), 2**63 - 1),
    **{f"Int{n}": (-(2 ** (n - 1)), 2 ** (n - 1) - 1) for n in (8, 16, 32, 64)},
    **{f"UInt{n}": (0, 2**n - 1) for n in (8, 16, 32, 64)},
}
"""Smallest and largest value of each integer type."""

Number = float | int
_FLOAT = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")  # linear: one way to match
_WORDS = {"INF": math.inf, "+INF": math.inf, "-INF": -math.inf, "NaN": math.nan}


def is_number(kind: str) -> bool:
    """Tell whether a variable of this type is compared, bounded and varied as a number."""
    return kind in FLOATS or kind in RANGES


def number(text: str | None, kind: str = "Float64") -> Number | None:
    """Return a number written for a type, or ``None`` when it is none."""
    if text is None:
        return None
    word = text.strip()
    if kind in RANGES:
        return int(word) if re.fullmatch(r"[+-]?\d{1,30}", word) else None
    if word in _WORDS:
        return _WORDS[word]
    return float(word) if _FLOAT.fullmatch(word) else None


def boolean(text: str | None) -> bool:
    """Return whether an attribute says true."""
    return (text or "").strip() in ("true", "1")


def whole(text: str | None) -> int | None:
    """Return a value reference or an index; ``None`` when it is none."""
    word = (text or "").strip()
    return int(word) if re.fullmatch(r"\d{1,20}", word) else None


def listed(names: Iterable[str], most: int = 5) -> str:
    """Return names as text, the first few of many."""
    every = list(names)
    more = f" and {len(every) - most} more" if len(every) > most else ""
    return ", ".join(every[:most]) + more


Attributes = dict[str, str]

# Effective initial where none is written; first of those allowed (FMI 2.0.5, 2.2.7; 3.0.2, 2.4.7).
_CHANGING = ("calculated", "exact", "approx")
INITIALS: dict[tuple[str, str], tuple[str, ...]] = {
    ("structuralParameter", "fixed"): ("exact",),
    ("structuralParameter", "tunable"): ("exact",),
    ("parameter", "fixed"): ("exact",),
    ("parameter", "tunable"): ("exact",),
    ("calculatedParameter", "fixed"): ("calculated", "approx"),
    ("calculatedParameter", "tunable"): ("calculated", "approx"),
    ("input", "discrete"): (),
    ("input", "continuous"): (),
    ("output", "constant"): ("exact",),
    ("output", "discrete"): _CHANGING,
    ("output", "continuous"): _CHANGING,
    ("local", "constant"): ("exact",),
    ("local", "fixed"): ("calculated", "approx"),
    ("local", "tunable"): ("calculated", "approx"),
    ("local", "discrete"): _CHANGING,
    ("local", "continuous"): _CHANGING,
    ("independent", "continuous"): (),
}
"""Causality and variability -> allowed initials, the default first; absent: not allowed."""


@dataclass(frozen=True, eq=False)
class TypeDefinition:
    """A type that variables can declare; ``items`` are names and values of an enumeration."""

    name: str
    kind: str
    line: int
    given: Attributes
    items: tuple[tuple[str, str], ...] = ()

    @property
    def place(self) -> str:
        """Where it is."""
        return f"type {self.name} (line {self.line})"


@dataclass(frozen=True)
class Unit:
    """A unit with its display units; ``base`` and ``display`` hold the attributes as written."""

    name: str
    line: int
    base: Attributes | None
    display: tuple[Attributes, ...]

    @property
    def place(self) -> str:
        """Where it is."""
        return f"unit {self.name} (line {self.line})"


@dataclass(frozen=True)
class Dimension:
    """One dimension of an array: a fixed length or the reference of the variable that holds it."""

    start: int | None
    reference: int | None


@dataclass(frozen=True, eq=False)
class Variable:
    """One variable.

    Attributes
    ----------
    index : place in ModelVariables, from 1
    kind : Real, Float64, Int32, ...
    given : all attributes as written
    initial : the one in force, which may be a default
    start : as written, one for each element; ``None`` when there is none
    derivative : index (FMI 2.0) or value reference (FMI 3.0) of the state
    aliases : attributes of each Alias
    """

    index: int
    line: int
    name: str
    reference: int | None
    kind: str
    causality: str
    variability: str
    initial: str | None
    given: Attributes
    start: tuple[str, ...] | None = None
    derivative: int | None = None
    previous: int | None = None
    clocks: tuple[int, ...] | None = None
    dimensions: tuple[Dimension, ...] = ()
    aliases: tuple[Attributes, ...] = ()
    type: TypeDefinition | None = None

    @property
    def place(self) -> str:
        """Where it is."""
        return f"variable {self.name} (line {self.line})"

    def get(self, attribute: str) -> str | None:
        """Return an attribute, of the declared type where the variable has none itself."""
        return self.given.get(attribute, self.type.given.get(attribute) if self.type else None)

    def number(self, attribute: str) -> Number | None:
        """Return an attribute as a number of the variable's type."""
        return number(self.get(attribute), self.kind) if is_number(self.kind) else None

    @property
    def start_numbers(self) -> list[Number]:
        """The start values that are numbers."""
        texts = self.start if self.start and is_number(self.kind) else ()
        return [n for n in (number(text, self.kind) for text in texts) if n is not None]


@dataclass(frozen=True)
class Unknown:
    """An entry of ModelStructure.

    Attributes
    ----------
    key : index or value reference as written
    variable, dependencies : resolved; ``None`` where no such variable exists
    """

    group: str
    line: int
    key: str
    variable: Variable | None
    dependencies: tuple[tuple[str, Variable | None], ...] | None
    kinds: tuple[str, ...] | None

    @property
    def place(self) -> str:
        """Where it is."""
        name = self.variable.name if self.variable else self.key
        return f"ModelStructure, {self.group} {name} (line {self.line})"


@dataclass(frozen=True)
class Interface:
    """ModelExchange, CoSimulation or ScheduledExecution, with attributes and listed sources."""

    kind: str
    line: int
    given: Attributes
    sources: tuple[str, ...] = ()

    @property
    def identifier(self) -> str:
        """The name of the binary."""
        return self.given.get("modelIdentifier", "")

    def flag(self, name: str) -> bool:
        """Return a capability; FMI 2.0 and 3.0 spell some differently."""
        low = name.casefold().rstrip("s")
        return any(boolean(v) for k, v in self.given.items() if k.casefold().rstrip("s") == low)

    @property
    def place(self) -> str:
        """Where it is."""
        return f"{self.kind} (line {self.line})"


@dataclass
class Description:
    """All of modelDescription.xml that rules ask for; ``root`` holds the root's attributes."""

    version: int
    root: Attributes
    interfaces: list[Interface]
    units: list[Unit]
    types: list[TypeDefinition]
    categories: list[str]
    experiment: Attributes | None
    variables: list[Variable]
    unknowns: list[Unknown] = field(default_factory=list)

    @property
    def token(self) -> str:
        """The string that the binary is to check."""
        return self.root.get("guid" if self.version == 2 else "instantiationToken", "")

    @cached_property
    def by_key(self) -> dict[int, Variable]:
        """Index (FMI 2.0) or value reference (FMI 3.0) -> variable."""
        if self.version == 2:
            return {v.index: v for v in self.variables}
        return {v.reference: v for v in reversed(self.variables) if v.reference is not None}

    def group(self, name: str) -> list[Unknown]:
        """Return the entries of ModelStructure of one kind."""
        return [unknown for unknown in self.unknowns if unknown.group == name]

    @cached_property
    def derivatives(self) -> list[Variable]:
        """The state derivatives, in the order of the API."""
        return [u.variable for u in self.group("ContinuousStateDerivative") if u.variable]

    @cached_property
    def states(self) -> list[Variable]:
        """The continuous states, in the order of the API."""
        states = (
            self.by_key.get(v.derivative) for v in self.derivatives if v.derivative is not None
        )
        return [state for state in states if state]

    def interface(self, kind: str) -> Interface | None:
        """Return an interface, if the FMU has it."""
        return next((each for each in self.interfaces if each.kind == kind), None)


@dataclass(frozen=True)
class Fmu:
    """An FMU in a folder of its own.

    ``members`` are the paths of all files in the archive, with forward slashes.
    """

    path: Path
    folder: Path
    members: frozenset[str]
    description: Description

    def bytes(self, name: str) -> bytes:
        """Return a member's content."""
        return (self.folder / name).read_bytes()

    def below(self, prefix: str) -> list[str]:
        """Return the members below a folder, sorted."""
        return sorted(name for name in self.members if name.startswith(prefix))

    @property
    def identifiers(self) -> list[str]:
        """The names of the binaries, each once."""
        return list(dict.fromkeys(each.identifier for each in self.description.interfaces))


def length(dimension: Dimension, description: Description) -> int | None:
    """Return the initial length of a dimension, ``None`` when it is unknown."""
    if dimension.start is not None:
        return dimension.start
    source = (
        description.by_key.get(dimension.reference) if dimension.reference is not None else None
    )
    starts = source.start_numbers if source else []
    return int(starts[0]) if starts else None


def size(variable: Variable, description: Description) -> int | None:
    """Return how many elements a variable has at first, 1 for a scalar."""
    lengths = [length(d, description) for d in variable.dimensions]
    known = [n for n in lengths if n is not None]
    return math.prod(known) if len(known) == len(lengths) else None


def items_of(variable: Variable) -> set[int]:
    """Return the values of a variable's enumeration."""
    declared: TypeDefinition | None = variable.type
    values = (number(value, "Enumeration") for _, value in (declared.items if declared else ()))
    return {int(v) for v in values if v is not None}


def experiment_number(description: Description, name: str) -> Number | None:
    """Return an attribute of the default experiment."""
    return number((description.experiment or {}).get(name))
