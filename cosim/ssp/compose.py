"""Adds elements of SSP in the order of the schemas, and packs the files of a package."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterable
from typing import Any

from lxml import etree

from stickslip.cosim.ssp.markup import NAMESPACES, OSP, local, tag
from stickslip.fmi.description.units import BASE_UNITS, Unit
from stickslip.fmi.description.variables import Variable

# Order of the elements of a description, a system and a component in the schemas.
_ORDER = (
    "Connectors ElementGeometry ParameterBindings Elements Connections SignalDictionaries"
    " SystemGeometry GraphicalElements System Parameters Enumerations Units DefaultExperiment"
    " MetaData Signature Annotations"
)
_RANK = {name: rank for rank, name in enumerate(_ORDER.split())}
_FLOATS = {"Real", "Float64", "Float32"}
_OTHERS = {"Boolean", "String", "Enumeration", "Binary"}


def new_root(name: str, title: str, version: str) -> Any:
    """Return the root of a new file."""
    prefix = name.partition(":")[0]
    # libcosim takes a namespace declared on osp:Algorithm itself for an algorithm
    nsmap = {key: NAMESPACES[key] for key in (prefix, "ssc")} | {"osp": OSP}
    return etree.Element(tag(name), {"version": version, "name": title}, nsmap=nsmap)


def add(parent: Any, name: str, /, **attributes: str) -> Any:
    """Append an element."""
    return etree.SubElement(parent, tag(name), attributes)


def group(parent: Any, name: str) -> Any:
    """Return the child of this name, a new one in the order of the schemas if there is none."""
    found = parent.find(tag(name))
    if found is not None:
        return found
    new = etree.Element(tag(name))
    rank = _RANK[local(new)]
    behind = (c for c in parent.iterchildren("{*}*") if _RANK.get(local(c), 0) > rank)
    follower = next(behind, None)
    if follower is None:
        parent.append(new)
    else:
        follower.addprevious(new)
    return new


def discard(element: Any) -> None:
    """Remove an element, and its parent if that is empty then."""
    parent = element.getparent()
    parent.remove(element)
    if not len(parent) and local(parent) in {"Connectors", "Connections", "Elements"}:
        parent.getparent().remove(parent)


def add_connector(
    root: Any,
    element: Any,
    name: str,
    kind: str,
    variable: Variable,
    version: str,
    unit: Unit | None,
) -> None:
    """Give an element of a description a connector for a variable."""
    connector = add(group(element, "ssd:Connectors"), "ssd:Connector", name=name, kind=kind)
    type_name = type_of(variable, version)
    attributes = {}
    if type_name == "Enumeration":
        attributes["name"] = add_enumeration(root, variable)
    elif unit and unit.exponents and type_name in _FLOATS:
        attributes["unit"] = unit.name
    add(connector, f"ssc:{type_name}", **attributes)
    for length in variable.dimensions:
        add(connector, "ssc:Dimension", size=str(length))


def add_enumeration(root: Any, variable: Variable) -> str:
    """Define the enumeration of a variable that has no definition yet; return its name."""
    known = {
        enumeration.get("name"): [(item.get("name"), item.get("value")) for item in enumeration]
        for enumeration in root.iter(tag("ssc:Enumeration"))
        if len(enumeration)
    }
    wanted = [(name, str(value)) for name, value in variable.items]
    name = variable.enumeration or "Enumeration"
    while known.get(name, wanted) != wanted:
        name += "_"
    if name not in known:
        new = add(group(root, "ssd:Enumerations"), "ssc:Enumeration", name=name)
        for item, value in wanted:
            add(new, "ssc:Item", name=item, value=value)
    return name


def add_units(root: Any, name: str, units: Iterable[Unit]) -> None:
    """Define units that have no definition yet."""
    known = {unit.get("name") for unit in root.iter(tag("ssc:Unit"))}
    for unit in units:
        if unit.name in known or not unit.exponents:
            continue
        known.add(unit.name)
        base = add(add(group(root, name), "ssc:Unit", name=unit.name), "ssc:BaseUnit")
        for base_unit, exponent in zip(BASE_UNITS, unit.exponents, strict=True):
            if exponent:
                base.set(base_unit, str(exponent))
        if unit.factor != 1.0:
            base.set("factor", repr(unit.factor))
        if unit.offset != 0.0:
            base.set("offset", repr(unit.offset))


def type_of(variable: Variable, version: str) -> str:
    """Return the type of SSP for a variable: FMI 3.0 has its own in SSP 2.0 only."""
    if variable.type == "Enumeration" and not variable.items:
        return "Integer" if version == "1.0" else "Int64"
    if variable.type in _OTHERS or variable.type in {"Real", "Integer"} or version != "1.0":
        return variable.type
    return "Real" if variable.type in _FLOATS else "Integer"


def text_of(root: Any) -> bytes:
    """Return a file."""
    text: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True)
    return text


_TIMESTAMP = (1980, 1, 1, 0, 0, 0)  # the same system gives the same bytes
Members = dict[str, bytes]


def file_name(i: int, name: str) -> str:
    """Return a file name for a component."""
    return re.sub(r"[^\w-]", "_", f"{i}_{name}", flags=re.ASCII)


def free_name(stem: str, suffix: str, members: Members) -> str:
    """Return a member name that is not taken."""
    name, n = stem + suffix, 1
    while name in members:
        n += 1
        name = f"{stem}_{n}{suffix}"
    return name


def zipped(members: Members) -> bytes:
    """Return the package."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in sorted(members.items()):
            member = zipfile.ZipInfo(name, _TIMESTAMP)
            member.compress_type = zipfile.ZIP_DEFLATED
            member.create_system = 3
            member.external_attr = 0o644 << 16
            archive.writestr(member, content)
    return buffer.getvalue()
