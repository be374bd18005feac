"""Rules about names, interfaces, units, types and log categories."""

import math
import re
from collections.abc import Iterator

from stickslip.fmi.description.attributes import flag
from stickslip.fmucheck.description.model import (
    Attributes,
    Description,
    Entry,
    Interface,
    Variable,
    number,
    repeated,
)
from stickslip.fmucheck.rules import Claims, error, note, warning

_C_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_UTC = re.compile(r"\d{4}-\d{2}-\d{2}T\d{2}:\d{2}:\d{2}(\.\d+)?Z")
_FILE = "modelDescription.xml"


@error("2.2.1", "2.4.1", "declare an interface that the binary has")
def no_interface(description: Description) -> Claims:
    """There is neither ModelExchange nor CoSimulation nor ScheduledExecution."""
    if not description.interfaces:
        yield _FILE, "no interface is declared"


@error("2.1.1", "2.2", "use letters, digits and _, no digit first", "interfaces")
def bad_model_identifier(interface: Interface) -> Iterator[str]:
    """The modelIdentifier is not a C name; with path separators it points outside the FMU."""
    if not _C_NAME.fullmatch(interface.identifier):
        yield f'modelIdentifier="{interface.identifier}" is not a C name'


@warning("2.2.1", "2.4.1", "write a hash of the interface")
def empty_token(description: Description) -> Claims:
    """The guid or instantiationToken is empty, so nothing ties description and binary."""
    if not description.token.strip():
        yield _FILE, f"{'guid' if description.version == 2 else 'instantiationToken'} is empty"


@warning("2.2.1", "2.4.1", "name the model")
def empty_model_name(description: Description) -> Claims:
    """The modelName is empty."""
    if not description.root.get("modelName", "").strip():
        yield _FILE, "modelName is empty"


@warning("2.2.1", "2.4.1", "write YYYY-MM-DDThh:mm:ssZ")
def date_not_utc(description: Description) -> Claims:
    """The generationDateAndTime is not written as UTC with Z."""
    date = description.root.get("generationDateAndTime")
    if date is not None and not _UTC.fullmatch(date.strip()):
        yield _FILE, f'generationDateAndTime="{date}"'


@note("2.2.1", "2.4.1", "fill them in")
def missing_metadata(description: Description) -> Claims:
    """Attributes that say where the FMU comes from are missing."""
    wanted = ("description", "author", "version", "license", "generationTool")
    missing = [name for name in wanted if not description.root.get(name)]
    if missing:
        yield _FILE, f"lacks {', '.join(missing)}"


@note("2.2.7", "2.4.7", "describe them")
def undescribed_variables(description: Description) -> Claims:
    """Inputs, outputs or parameters have no description."""
    shown = ("input", "output", "parameter", "structuralParameter")
    named = [v for v in description.variables if v.causality in shown]
    bare = [v.name for v in named if not v.get("description")]
    if bare:
        yield _FILE, f"{len(bare)} inputs, outputs and parameters have no description, as {bare[0]}"


def _with_units(description: Description) -> Iterator[tuple[str, Attributes, Attributes]]:
    """Yield place, attributes, and those that hold where the first are silent."""
    for each in description.types:
        yield each.place, each.given, {}
    for v in description.variables:
        inherited = v.type.given if v.type else {}
        yield v.place, v.given, inherited
        for alias in v.aliases:
            name = alias.get("name", "")
            yield f"alias {name} of {v.place}", alias, {"unit": v.get("unit") or ""}


@error("2.2.2", "2.4.3", "define it in UnitDefinitions")
def undefined_unit(description: Description) -> Claims:
    """A variable or type has a unit that is not defined."""
    known = {unit.name for unit in description.units}
    for place, given, _ in _with_units(description):
        unit = given.get("unit")
        if unit is not None and unit not in known:
            yield place, f"unit '{unit}' is not defined"


@error("2.2.2", "2.4.3", "define it under the variable's unit")
def undefined_display_unit(description: Description) -> Claims:
    """A display unit is not defined under the unit it belongs to, or there is no unit."""
    known = {u.name: {d.get("name") for d in u.parts["DisplayUnit"]} for u in description.units}
    for place, given, inherited in _with_units(description):
        shown, unit = given.get("displayUnit"), given.get("unit") or inherited.get("unit")
        if shown is None or (unit and unit not in known):
            continue
        if not unit:
            yield place, f"displayUnit '{shown}' without a unit"
        elif shown not in known[unit]:
            yield place, f"displayUnit '{shown}' is not defined under unit '{unit}'"


@error("2.2.2", "2.4.3", "keep one definition")
def duplicate_unit(description: Description) -> Claims:
    """A unit is defined twice, or a display unit twice in one unit."""
    for name, _ in repeated([unit.name for unit in description.units]):
        yield f"unit {name}", "is defined more than once"
    for unit in description.units:
        for name, _ in repeated(d.get("name", "") for d in unit.parts["DisplayUnit"]):
            yield unit.place, f"display unit {name} is defined more than once"


@error("2.2.2", "2.4.3", "write a factor other than 0", "units")
def bad_unit_factor(unit: Entry) -> Iterator[str]:
    """The factor of a unit is 0, or factor or offset are not finite."""
    each = [("BaseUnit", base) for base in unit.parts["BaseUnit"]]
    each += [(f"DisplayUnit {one.get('name')}", one) for one in unit.parts["DisplayUnit"]]
    for name, given in each:
        factor, offset = number(given.get("factor", "1")), number(given.get("offset", "0"))
        if factor == 0.0 or not all(math.isfinite(n) for n in (factor, offset) if n is not None):
            yield f"{name}: factor {factor}, offset {offset}"


@error(None, "2.4.3", "drop offset or inverse", "units")
def inverse_with_offset(unit: Entry) -> Iterator[str]:
    """An inverse display unit has an offset."""
    for each in unit.parts["DisplayUnit"]:
        if flag(each, "inverse") and number(each.get("offset", "0")) != 0:
            yield f"DisplayUnit {each.get('name')} is inverse and has an offset"


@note("2.2.2", "2.4.3", "give the exponents of the SI units")
def unit_without_base(description: Description) -> Claims:
    """A unit has no BaseUnit, so that importers can neither convert nor compare it."""
    bare = [unit for unit in description.units if not unit.parts["BaseUnit"]]
    if bare:
        yield bare[0].place, f"no BaseUnit; {len(bare)} such units"


@error("2.2.3", "2.4.4", "rename one of them")
def duplicate_type(description: Description) -> Claims:
    """Two types have the same name, or a type and a variable."""
    for name, _ in repeated([each.name for each in description.types]):
        yield f"type {name}", "is defined more than once"
    variables = {v.name: v for v in description.variables}
    for each in description.types:
        if each.name in variables:
            yield each.place, f"has the name of {variables[each.name].place}"


@error("2.2.3", "2.4.4", "define it in TypeDefinitions", "variables")
def undefined_type(v: Variable) -> Iterator[str]:
    """A variable declares a type that is not defined, or one of another kind."""
    declared = v.given.get("declaredType")
    if declared is None:
        return
    if v.type is None:
        yield f"declaredType '{declared}' is not defined"
    elif v.type.kind != v.kind:
        yield f"is {v.kind}, but its declaredType '{declared}' is {v.type.kind}"


@error("2.2.3", "2.4.4", "give each item its own name and value", "types")
def duplicate_item(each: Entry) -> Iterator[str]:
    """Two items of an enumeration share a name or a value."""
    for what in ("name", "value"):
        for text, _ in repeated(item.get(what, "") for item in each.parts["Item"]):
            yield f"several items have the {what} {text}"


@error("2.2.4", "2.4.5", "list each category once, by name")
def bad_log_category(description: Description) -> Claims:
    """A log category is listed twice or has no name."""
    for name, _ in repeated(description.categories):
        yield "LogCategories", f"'{name}' is listed more than once"
    if "" in description.categories:
        yield "LogCategories", "a category has no name"
