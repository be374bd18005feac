"""Turns the files of a package into another version of SSP."""

from __future__ import annotations

from collections.abc import Mapping

from lxml import etree

from stickslip.cosim.errors import SspError
from stickslip.cosim.ssp.markup import short
from stickslip.cosim.ssp.names import NAMESPACES, ROOTS, tag
from stickslip.cosim.ssp.schema import violation
from stickslip.fmi.xml import Malformed, parse_xml

_WHOLE = ("Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64")
_OLD_NAMES = {"Float64": "Real", "Float32": "Real", **dict.fromkeys(_WHOLE, "Integer")}


def as_version(members: Mapping[str, bytes], version: str) -> dict[str, bytes]:
    """Return the members of a package in a version; those that are of it already stay untouched.

    Raises
    ------
    SspError
        When a file says what SSP 1.0 has no words for.
    """
    return {name: _converted(name, data, version) for name, data in members.items()}


def _converted(name: str, data: bytes, version: str) -> bytes:
    part = name.rpartition(".")[2]
    if part not in ROOTS:
        return data
    try:
        root = parse_xml(data, remarks=True)
    except Malformed as fault:
        raise SspError(f"{name}: {fault}") from fault
    roots = [element for kind in ROOTS.values() for element in root.iter(tag(kind))]
    if all(element.get("version") == version for element in roots):
        return data
    for element in roots:
        element.set("version", version)
    if version == "1.0":
        for prefix in ("ssc", "ssv"):
            for new, old in _OLD_NAMES.items():
                for element in root.iter(f"{{{NAMESPACES[prefix]}}}{new}"):
                    element.tag = f"{{{NAMESPACES[prefix]}}}{old}"
    if breach := violation(root, part, version):
        said = short(breach[1])
        raise SspError(f"{name}, line {breach[0]}: SSP {version} cannot say this: {said}")
    text: bytes = etree.tostring(root, xml_declaration=True, encoding="UTF-8")
    return text
