"""What a description says, as plain data: it travels to the child process."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

from stickslip.fmucheck.description.values import Number, boolean, is_number, number

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
