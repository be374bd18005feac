"""What modelDescription.xml says, as it is written: numbers stay text, and nothing is refused.

Rules find what ``stickslip.fmi.description`` refuses, repairs or leaves out, so that its reader
cannot serve them; the tables of the standard are those of that reader. All is plain data, which is
sent to the child process.
"""

import math
import re
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from stickslip.fmi.description.attributes import flag
from stickslip.fmi.description.variables import FLOATS, INITIALS, default_variability
from stickslip.fmucheck.document import Element

RANGES = {
    "Integer": (-(2**31), 2**31 - 1),
    "Enumeration": (-(2**63), 2**63 - 1),
    **{f"Int{n}": (-(2 ** (n - 1)), 2 ** (n - 1) - 1) for n in (8, 16, 32, 64)},
    **{f"UInt{n}": (0, 2**n - 1) for n in (8, 16, 32, 64)},
}
"""Smallest and largest value of each integer type."""
Number = float | int
Attributes = dict[str, str]
_FLOAT = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?")  # linear: one way to match
_WORDS = {"INF": math.inf, "+INF": math.inf, "-INF": -math.inf, "NaN": math.nan}
_INTERFACES = ("ModelExchange", "CoSimulation", "ScheduledExecution")
# The lists of FMI 2.0 under the names that FMI 3.0 gives their members.
_GROUPS = {"Outputs": "Output", "Derivatives": "ContinuousStateDerivative"}
_GROUPS |= {"InitialUnknowns": "InitialUnknown"}


def is_number(kind: str) -> bool:
    """Tell whether a variable of this type is compared, bounded and varied as a number."""
    return kind in FLOATS or kind in RANGES


def number(text: str | None, kind: str = "Float64") -> Number | None:
    """Return a number written for a type, or ``None`` when it is none."""
    word = (text or "").strip()
    if kind in RANGES:
        return int(word) if re.fullmatch(r"[+-]?\d{1,30}", word) else None
    return _WORDS.get(word, float(word) if _FLOAT.fullmatch(word) else None)


def whole(text: str | None) -> int | None:
    """Return a value reference or an index; ``None`` when it is none."""
    word = (text or "").strip()
    return int(word) if re.fullmatch(r"\d{1,20}", word) else None


def listed(names: Iterable[str], most: int = 5) -> str:
    """Return names as text, the first few of many."""
    every = list(names)
    more = f" and {len(every) - most} more" if len(every) > most else ""
    return ", ".join(every[:most]) + more


def repeated(names: Iterable[Any]) -> list[tuple[Any, int]]:
    """Return what occurs more than once, and how often; None does not count."""
    return [(name, n) for name, n in Counter(names).items() if n > 1 and name is not None]


def _inside(element: Element | None) -> list[Element]:
    """Return the children that are elements; comments and entities are not."""
    return [] if element is None else [each for each in element if isinstance(each.tag, str)]


def _attributes(element: Element) -> Attributes:
    return {str(key): str(value) for key, value in element.attrib.items()}


class Entry:
    """An element; in FMI 2.0 a variable or type has kind, attributes and parts of the one inside.

    ``parts`` are the attributes of the elements in it by their tags.
    """

    def __init__(self, element: Element, what: str = "", version: int = 3) -> None:
        inside = _inside(element) if version == 2 else ()
        inner = next((each for each in inside if each.tag != "Annotations"), element)
        self.name: str = element.get("name", "")
        self.kind = str(inner.tag).removesuffix("Type")
        self.given = _attributes(inner)
        self.place = f"{what or self.kind} {self.name}".rstrip() + f" (line {element.sourceline})"
        self.parts = defaultdict[str, list[Attributes]](list)
        for part in _inside(inner):
            self.parts[part.tag].append(_attributes(part))


class Variable(Entry):
    """One variable.

    ``index`` is its place in ModelVariables, from 1; ``initial`` is in force, and may be a default;
    ``start`` is as written, one for each element; ``derivative`` is the index (FMI 2.0) or value
    reference (FMI 3.0) of the state; ``dimensions`` are pairs of a fixed length and the reference
    of the variable that holds it.
    """

    def __init__(self, element: Element, index: int, version: int, types: dict[str, Entry]) -> None:
        super().__init__(element, "variable", version)
        given = self.given = _attributes(element) | self.given
        self.index, self.version = index, version
        self.reference = whole(given.get("valueReference"))
        self.causality = given.get("causality", "local")
        default = default_variability(version, self.kind, self.causality)
        self.variability = given.get("variability") or default
        allowed = INITIALS.get((self.causality, self.variability), ())
        self.initial = given.get("initial") or (allowed[0] if allowed else None)
        text = given.get("start")
        if version == 3 and self.kind in ("String", "Binary"):
            texts = [each.get("value", "") for each in self.parts["Start"]] or None
        else:
            texts = None if text is None else [text] if version == 2 else text.split()
        self.start = None if texts is None else tuple(texts)
        self.derivative = whole(given.get("derivative"))
        self.previous = whole(given.get("previous"))
        clocks = given.get("clocks")
        self.clocks = None if clocks is None else tuple(whole(c) or 0 for c in clocks.split())
        lengths = self.parts["Dimension"]
        self.dimensions = [(whole(d.get("start")), whole(d.get("valueReference"))) for d in lengths]
        self.aliases = self.parts["Alias"]
        self.type = types.get(given.get("declaredType", ""))

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

    @property
    def items(self) -> set[int]:
        """The values of its enumeration."""
        texts = [item.get("value") for item in self.type.parts["Item"]] if self.type else []
        return {int(n) for n in (number(text, "Enumeration") for text in texts) if n is not None}


class Unknown:
    """An entry of ModelStructure; dependencies that do not exist are ``None``."""

    def __init__(
        self, element: Element, group: str, variable: Variable, description: "Description"
    ) -> None:
        self.group, self.variable = group, variable
        self.place = f"ModelStructure, {group} {variable.name} (line {element.sourceline})"
        depends, kinds = element.get("dependencies"), element.get("dependenciesKind")
        keys = None if depends is None else depends.split()
        self.dependencies = keys and [(key, description.variable(whole(key))) for key in keys]
        self.kinds = None if kinds is None else kinds.split()


class Interface(Entry):
    """ModelExchange, CoSimulation or ScheduledExecution; ``sources`` are those that it lists."""

    def __init__(self, element: Element) -> None:
        super().__init__(element)
        self.identifier = self.given.get("modelIdentifier", "")
        self.sources = [file.get("name", "") for file in element.iterfind("SourceFiles/File")]

    def flag(self, name: str) -> bool:
        """Return a capability; FMI 2.0 and 3.0 spell some differently."""
        low = name.casefold().rstrip("s")
        return any(flag(self.given, k) for k in self.given if k.casefold().rstrip("s") == low)


class Description:
    """All of modelDescription.xml that rules ask for.

    ``root`` holds the root's attributes, ``dangling`` place and key of the entries of
    ModelStructure whose variable does not exist; the others are ``unknowns``.
    """

    def __init__(self, root: Element, version: int) -> None:
        experiment = root.find("DefaultExperiment")
        self.version = version
        self.root = _attributes(root)
        self.interfaces = [Interface(each) for each in _inside(root) if each.tag in _INTERFACES]
        self.units = [Entry(each, "unit") for each in _inside(root.find("UnitDefinitions"))]
        types = _inside(root.find("TypeDefinitions"))
        self.types = [Entry(each, "type", version) for each in types]
        self.categories = [each.get("name", "") for each in _inside(root.find("LogCategories"))]
        self.experiment = None if experiment is None else _attributes(experiment)
        named = {each.name: each for each in self.types}
        found = enumerate(_inside(root.find("ModelVariables")), 1)
        self.variables = [Variable(each, index, version, named) for index, each in found]
        self.unknowns, self.dangling = list[Unknown](), list[tuple[str, str]]()
        for child in _inside(root.find("ModelStructure")):
            group = _GROUPS.get(child.tag, child.tag) if version == 2 else child.tag
            for entry in _inside(child) if version == 2 else [child]:
                key = entry.get("index" if version == 2 else "valueReference", "")
                if variable := self.variable(whole(key)):
                    self.unknowns.append(Unknown(entry, group, variable, self))
                else:
                    place = f"ModelStructure, {group} {key} (line {entry.sourceline})"
                    self.dangling.append((place, key))

    @property
    def token(self) -> str:
        """The string that the binary is to check."""
        return self.root.get("guid" if self.version == 2 else "instantiationToken", "")

    @cached_property
    def _by_key(self) -> dict[int, Variable]:
        if self.version == 2:
            return {v.index: v for v in self.variables}
        return {v.reference: v for v in reversed(self.variables) if v.reference is not None}

    def variable(self, key: int | None) -> Variable | None:
        """Return the variable with an index (FMI 2.0) or a value reference (FMI 3.0)."""
        return None if key is None else self._by_key.get(key)

    def group(self, name: str) -> list[Unknown]:
        """Return the entries of ModelStructure of one kind."""
        return [unknown for unknown in self.unknowns if unknown.group == name]

    @cached_property
    def derivatives(self) -> list[Variable]:
        """The state derivatives, in the order of the API."""
        return [u.variable for u in self.group("ContinuousStateDerivative")]

    @cached_property
    def states(self) -> list[Variable]:
        """The continuous states, in the order of the API."""
        states = (self.variable(v.derivative) for v in self.derivatives)
        return [state for state in states if state]

    @property
    def clocks(self) -> list[Variable]:
        """The clocks."""
        return [v for v in self.variables if v.kind == "Clock"]

    def interface(self, kind: str) -> Interface | None:
        """Return an interface, if the FMU has it."""
        return next((each for each in self.interfaces if each.kind == kind), None)

    def proposed(self, name: str) -> Number | None:
        """Return a number of the default experiment."""
        return number((self.experiment or {}).get(name))

    def length(self, fixed: int | None, reference: int | None) -> int | None:
        """Return the initial length of a dimension, ``None`` when it is unknown."""
        if fixed is not None:
            return fixed
        source = self.variable(reference)
        starts = source.start_numbers if source else []
        return int(starts[0]) if starts else None

    def size(self, variable: Variable) -> int | None:
        """Return how many elements a variable has at first, 1 for a scalar."""
        lengths = [self.length(*each) for each in variable.dimensions]
        known = [n for n in lengths if n is not None]
        return math.prod(known) if len(known) == len(lengths) else None

    def count(self, variables: Iterable[Variable]) -> int:
        """Return how many values variables have."""
        return sum(self.size(v) or 1 for v in variables)


@dataclass(frozen=True)
class Fmu:
    """An FMU in a folder of its own; ``members`` are its files, with forward slashes."""

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
