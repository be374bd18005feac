"""Variables from their elements.

Source: FMI 2.0 section 2.2.7, FMI 3.0 section 2.4.7.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any

from stickslip.fmi.description.attributes import (
    CONTROLS,
    WORDS,
    DescriptionFault,
    Remarks,
    TypeDefinition,
    flag,
    real,
    whole,
    whole_of,
)
from stickslip.fmi.description.variables import (
    FLOATS,
    INITIALS,
    MAX_ELEMENTS,
    NOT_NUMBERS,
    SETTERS,
    Scalar,
    Value,
    Variable,
    default_variability,
)
from stickslip.fmi.messages import shown

MAX_REFERENCE = 2**32 - 1
_TYPES = {2: frozenset(SETTERS[2]), 3: frozenset(SETTERS[3])}
_INITIALS = {None, "exact", "approx", "calculated"}
_LAWFUL = {**dict.fromkeys(("input", "output", "local"), "discrete"), "independent": "continuous"}
"""The variability that is taken where the one that is given does not go with the causality."""
_CAUSALITIES, _VARIABILITIES = map(set, zip(*INITIALS, strict=True))
Lengths = Mapping[int, tuple[str, int]]
"""Value reference of what can be a length -> its name and start value."""


def read_variable(
    element: Any,
    typed: Any,
    version: int,
    types: Mapping[str, TypeDefinition],
    lengths: Lengths,
    remarks: Remarks,
) -> Variable:
    """Return a variable; ``typed``: what ``typed_element`` returns."""
    name, kind = element.get("name"), typed.tag
    own = typed.attrib
    declared = remarks.attempt(_declared, own.get("declaredType"), types, name, element)
    given = declared.given if declared else own

    def text(attribute: str) -> str | None:
        found: str | None = own.get(attribute)
        return given.get(attribute) if found is None else found

    def number(attribute: str) -> float | None:
        found = text(attribute)
        what = f"{attribute} of {shown(name)}"
        return None if found is None else remarks.attempt(_number, found, what, element)

    sized = version == 3 and len(element)
    dimensions, structure = _dimensions(element, name, lengths) if sized else ((), ())
    causality, variability, initial = _roles(element, version, kind, name, remarks)
    low, high = (number("min"), number("max")) if kind not in NOT_NUMBERS else (None, None)
    if low is not None and high is not None and low > high:
        what = f"min of {shown(name)} is {low}, above its max {high}; both are ignored"
        remarks.add(element, what)
        low = high = None
    nominal = number("nominal") if kind in FLOATS else None
    if nominal is not None and not 0 < nominal < math.inf:
        what = f"nominal of {shown(name)} is {nominal}, expected a positive number"
        remarks.add(element, f"{what}; this is ignored")
        nominal = None
    start = remarks.attempt(_start, element, typed, kind, dimensions, name)
    if not _within(start, low, high):
        what = f"{shown(name)} starts at {shown(str(start))}, outside its range {low} to {high}"
        remarks.add(element, f"{what}; the FMU starts it so")
    return Variable(
        name=name,
        reference=whole_of(element, "valueReference", 0, MAX_REFERENCE),
        type=kind,
        causality=causality,
        variability=variability,
        initial=initial,
        unit=text("unit") if kind in FLOATS else None,
        start=start,
        minimum=low,
        maximum=high,
        nominal=nominal,
        description=element.get("description", ""),
        dimensions=dimensions,
        structure=structure,
        enumeration=declared.name if declared and kind == "Enumeration" else None,
        items=declared.items if declared and kind == "Enumeration" else (),
        triggered=kind == "Clock" and element.get("intervalVariability") == "triggered",
        relative=kind in FLOATS and flag({**given, **own}, "relativeQuantity"),
    )


def typed_element(element: Any, version: int) -> Any:
    """Return the element that has what belongs to the type: in FMI 2.0 the one inside."""
    for each in (element,) if version == 3 else element:
        if each.tag in _TYPES[version]:
            return each
    what = "has no type that is known"
    raise DescriptionFault(element, f"{element.tag} {shown(element.get('name', ''))} {what}")


def name_apart(element: Any, taken: set[str], remarks: Remarks) -> str:
    """Return a variable's name; where none is its own, it is given one with its reference."""
    written = element.get("name") or ""
    name = CONTROLS.sub(lambda found: repr(found[0])[1:-1], written)
    if not name or name in taken:
        name = f"{name}#{element.get('valueReference')}"
    if name in taken:
        raise DescriptionFault(element, f"a second variable {shown(written)}")
    if name != written:
        fault = f"a second variable {shown(written)}" if written in taken else "control characters"
        fault = fault if written else "the name of a variable is missing"
        remarks.add(element, f"{fault}; it is read as {shown(name)}")
        element.set("name", name)
    taken.add(name)
    return name


def _declared(
    name: str | None, types: Mapping[str, TypeDefinition], variable: str, element: Any
) -> TypeDefinition | None:
    if name is not None and name not in types:
        what = f"declaredType of {shown(variable)} is {shown(name)}, which is not defined"
        raise DescriptionFault(element, what)
    return types.get(name or "")


def _roles(
    element: Any, version: int, kind: str, name: str, remarks: Remarks
) -> tuple[str, str, str | None]:
    causality = element.get("causality", "local")
    variability = element.get("variability") or default_variability(version, kind, causality)
    initial = element.get("initial")
    known = causality in _CAUSALITIES and variability in _VARIABILITIES and initial in _INITIALS
    if known and (initial or (causality, variability) in INITIALS):
        return causality, variability, initial or _initial(causality, variability)
    words = ", ".join(shown(word) for word in (causality, variability, initial) if word)
    causality = causality if causality in _CAUSALITIES else "local"
    if (causality, variability) not in INITIALS:
        variability = _LAWFUL.get(causality, "fixed")
    remarks.add(
        element,
        f"{shown(name)} has a combination of causality, variability and initial that the standard"
        f" does not allow: {words}; it is read as a {variability} {causality}",
    )
    return causality, variability, _initial(causality, variability)


def _initial(causality: str, variability: str) -> str | None:
    allowed = INITIALS[causality, variability]
    return "exact" if causality == "input" else next(iter(allowed), None)


def _dimensions(
    element: Any, name: str, lengths: Lengths
) -> tuple[tuple[int, ...], tuple[str | None, ...]]:
    pairs = [_dimension(each, name, lengths) for each in element.iterfind("Dimension")]
    dimensions = tuple(length for length, _ in pairs)
    if len(dimensions) > 32 or math.prod(dimensions) > MAX_ELEMENTS:  # as many as numpy has
        what = f"array {shown(name)} is too large, at most {MAX_ELEMENTS} elements are read"
        raise DescriptionFault(element, what)
    return dimensions, tuple(source for _, source in pairs)


def _dimension(element: Any, name: str, lengths: Lengths) -> tuple[int, str | None]:
    if (element.get("start") is None) == (element.get("valueReference") is None):
        what = f"a Dimension of {shown(name)} needs either start or valueReference"
        raise DescriptionFault(element, what)
    if element.get("start") is not None:
        return whole_of(element, "start", 1, MAX_ELEMENTS), None
    reference = whole_of(element, "valueReference", 0, MAX_REFERENCE)
    if reference not in lengths:
        what = "the value reference of a structural parameter or constant"
        said = f"a Dimension of {shown(name)} refers to {reference}, expected {what}"
        raise DescriptionFault(element, f"{said}, an integer with a start value")
    source, length = lengths[reference]
    if not 0 < length <= MAX_ELEMENTS:
        what = f"a Dimension of {shown(name)} has the length {shown(source)} = {length}"
        raise DescriptionFault(element, f"{what}, expected 1 to {MAX_ELEMENTS}")
    return length, source


def _start(element: Any, typed: Any, kind: str, sizes: tuple[int, ...], name: str) -> Value | None:
    if kind == "Clock":
        return None
    if typed is element and kind in ("String", "Binary"):
        first = element.find("Start")
        text = None if first is None else first.get("value", "")
    else:
        text = typed.get("start")
    if text is None:
        return None
    read = _READERS.get(kind, whole)
    what = f"start of {shown(name)}"
    if not sizes:
        return read(text, what, element)
    if kind in ("String", "Binary"):
        return None
    values = tuple(read(word, what, element) for word in text.split())
    size = math.prod(sizes)
    if len(values) not in (1, size):
        raise DescriptionFault(element, f"{what} has {len(values)} values, expected {size}")
    return values * size if len(values) == 1 else values


def _within(start: Value | None, low: float | None, high: float | None) -> bool:
    """Tell whether a start value that the FMU itself gives is in the variable's range."""
    if (low is None and high is None) or isinstance(start, (str, bytes, bool, type(None))):
        return True
    least, most = -math.inf if low is None else low, math.inf if high is None else high
    values = start if isinstance(start, tuple) else (start,)
    return all(least <= x <= most for x in values if not isinstance(x, (str, bytes)))


def _number(text: str, what: str, element: Any) -> float:
    """Return a number that is not NaN."""
    number = real(text, what, element)
    if math.isnan(number):
        raise DescriptionFault(element, f"{what} is nan, expected a number")
    return number


def _truth(text: str, what: str, element: Any) -> bool:
    if text.strip() not in WORDS:
        raise DescriptionFault(element, f"{what} is {shown(text)}, expected true or false")
    return WORDS[text.strip()]


def _bytes(text: str, what: str, element: Any) -> bytes:
    try:
        return bytes.fromhex(text)
    except ValueError:
        said = f"{what} is {shown(text)}, expected hexadecimal digits"
        raise DescriptionFault(element, said) from None


_READERS: Mapping[str, Callable[[str, str, Any], Scalar]] = {
    **dict.fromkeys(FLOATS, _number),
    "Boolean": _truth,
    "String": lambda text, _what, _element: text,
    "Binary": _bytes,
}
