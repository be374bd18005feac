"""Rules about names, value references and aliases."""

from __future__ import annotations

import re
from collections import Counter, defaultdict

from stickslip.fmucheck.description.model import Description, Variable
from stickslip.fmucheck.description.values import listed
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule

# The grammar of structured names (FMI 2.0.5, 2.2.9; FMI 3.0.2, 2.4.7.5.1), token by token.
_INDICES = r"(\[\d+(,\d+)*\])?"
_QUOTED = r"'([A-Za-z0-9_!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]|\\['\"?\\abfnrtv])+'"
_PART = rf"([A-Za-z_][A-Za-z0-9_]*|{_QUOTED}){_INDICES}"
_IDENTIFIER = rf"{_PART}(\.{_PART})*"
_STRUCTURED = re.compile(rf"{_IDENTIFIER}|der\({_IDENTIFIER}(,\d+)?\)")


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7", advice="give each variable a name of its own")
def duplicate_name(description: Description) -> Claims:
    """Two variables, or a variable and an alias, have the same name."""
    names = [v.name for v in description.variables]
    names += [a.get("name", "") for v in description.variables for a in v.aliases]
    for name, count in Counter(names).items():
        if count > 1:
            yield f"variable {name}", f"{count} variables have this name"


@rule(Severity.ERROR, fmi2="2.2.7", fmi3="2.4.7", advice="name it")
def empty_name(description: Description) -> Claims:
    """A variable has no name."""
    for v in description.variables:
        if not v.name:
            yield v.place, f"variable number {v.index} has no name"


@rule(Severity.ERROR, fmi2=None, fmi3="2.4.7", advice="give each variable a reference of its own")
def duplicate_reference(description: Description) -> Claims:
    """Two variables have the same value reference."""
    first: dict[int, Variable] = {}
    for v in description.variables:
        if v.reference is not None and first.setdefault(v.reference, v) is not v:
            yield v.place, f"has the value reference {v.reference} of {first[v.reference].place}"


@rule(Severity.ERROR, fmi2="2.2.9", fmi3="2.4.7", advice="name it by the grammar, or declare flat")
def bad_structured_name(description: Description) -> Claims:
    """A name does not follow the convention 'structured' that the FMU declares."""
    if description.root.get("variableNamingConvention") != "structured":
        return
    for v in description.variables:
        for name in (v.name, *(alias.get("name", "") for alias in v.aliases)):
            if not _STRUCTURED.fullmatch(name):
                yield v.place, f"'{name}' is no structured name"


def _alias_sets(description: Description) -> list[list[Variable]]:
    """Return the sets of variables of FMI 2.0 that share one value."""
    sets = defaultdict(list)
    for v in description.variables:
        kind = "Integer" if v.kind == "Enumeration" else v.kind
        sets[kind, v.reference].append(v)
    return [variables for variables in sets.values() if len(variables) > 1]


@rule(Severity.ERROR, fmi2="2.2.7", fmi3=None, advice="give the start value to one of them")
def alias_starts(description: Description) -> Claims:
    """Variables that share a value give more than one start value, or constants differing ones."""
    for variables in _alias_sets(description):
        starts = [v for v in variables if v.start is not None]
        constant = all(v.variability == "constant" for v in starts)
        if len(starts) > 1 and not (constant and len({v.start for v in starts}) == 1):
            yield starts[1].place, f"{listed(v.name for v in starts)} share a value and a start"


@rule(Severity.ERROR, fmi2="2.2.7", fmi3=None, advice="give all of them the same unit")
def alias_units(description: Description) -> Claims:
    """Variables that share a value have different units."""
    for variables in _alias_sets(description):
        units = {v.get("unit") for v in variables}
        if len(units) > 1:
            names = listed(f"{v.name} [{v.get('unit') or 'no unit'}]" for v in variables)
            yield variables[1].place, f"{names} share a value"


@rule(Severity.ERROR, fmi2="2.2.7", fmi3=None, advice="give one of them its own value reference")
def alias_inputs(description: Description) -> Claims:
    """Several variables that can be set share a value, or a constant shares one that varies."""
    for variables in _alias_sets(description):
        settable = [v for v in variables if v.causality in ("input", "parameter", "independent")]
        if len(settable) > 1:
            yield settable[1].place, f"{listed(v.name for v in settable)} share a value"
        if len({v.variability == "constant" for v in variables}) > 1:
            names = listed(f"{v.name} ({v.variability})" for v in variables)
            yield variables[1].place, f"{names} share a value"
