"""Structured text as XML of PLCopen, TC6 2.01, which development systems of PLCs import whole."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lxml import etree

_TC6, _XHTML = "http://www.plcopen.org/xml/tc6_0201", "http://www.w3.org/1999/xhtml"
_COMMENT = r"\(\*((?:(?!\*\)).)*)\*\)"
_UNIT = re.compile(
    rf"^(?:{_COMMENT}\n)?(TYPE|FUNCTION|FUNCTION_BLOCK) (\w+)(?: : ?)?(.*?)END_\2\b;?$",
    re.DOTALL | re.MULTILINE,
)
_ARRAY = re.compile(r"ARRAY\[(\d+)\.\.(\d+)\] OF (\w+);")
_SECTION = re.compile(r"^VAR(|_INPUT|_OUTPUT|_IN_OUT)\n(.*?)^END_VAR\n", re.DOTALL | re.MULTILINE)
_PARTS = {"": "localVars", "_INPUT": "inputVars", "_OUTPUT": "outputVars", "_IN_OUT": "inOutVars"}
_VARIABLE = re.compile(rf"^ +(\w+) : (\w+)(?: := (.*?))?;(?: {_COMMENT})?$", re.MULTILINE)
_ELEMENTARY = ("LREAL", "INT", "DINT", "BOOL")
_STATED = r"learned on (\d{4}-\d\d-\d\d) ", r"exported with (\S+)"  # in the head of the code


def plcopen_text(name: str, text: str) -> str:
    """Return the types, functions and function blocks of structured text as a project."""
    from lxml import etree  # late, for those who start quickly

    project = etree.Element("project", nsmap={None: _TC6})
    date, version = (re.search(pattern, text) for pattern in _STATED)
    header = {"companyName": "stickslip", "productName": "stickslip"}
    header["productVersion"] = version[1] if version else "1"
    header["creationDateTime"] = f"{date[1] if date else '1980-01-01'}T00:00:00"
    _add(project, "fileHeader", **header)
    content = _add(project, "contentHeader", name=name)
    heads = re.findall(_COMMENT, _UNIT.sub("", text), re.DOTALL)
    _add(content, "Comment").text = "\n\n".join(map(str.strip, heads))
    coordinates = _add(content, "coordinateInfo")
    for kind in ("fbd", "ld", "sfc"):
        _add(_add(coordinates, kind), "scaling", x="1", y="1")
    types = _add(project, "types")
    data, pous = _add(types, "dataTypes"), _add(types, "pous")
    for comment, kind, unit, rest in _UNIT.findall(text):
        if kind == "TYPE":
            base = _add(_add(data, "dataType", name=unit), "baseType")
            if array := _ARRAY.search(rest):
                inner = _add(base, "array")
                _add(inner, "dimension", lower=array[1], upper=array[2])
                _type(_add(inner, "baseType"), array[3])
            else:
                _variables(_add(base, "struct"), rest)
            continue
        pou = _add(pous, "pou", name=unit, pouType=kind.lower().replace("_b", "B"))
        interface = _add(pou, "interface")
        returned, _, body = rest.partition("\n")
        if returned:
            _type(_add(interface, "returnType"), returned)
        for section, declared in _SECTION.findall(body):
            _variables(_add(interface, _PARTS[section]), declared)
        _text(_add(_add(pou, "body"), "ST"), _SECTION.sub("", body))
        if comment:
            _text(_add(pou, "documentation"), comment.strip())
    _add(_add(project, "instances"), "configurations")
    etree.indent(project)
    written: bytes = etree.tostring(project, encoding="utf-8", xml_declaration=True)
    return written.decode() + "\n"


def _add(parent: etree._Element, tag: str, **attributes: str) -> etree._Element:
    from lxml import etree

    return etree.SubElement(parent, f"{{{_TC6}}}{tag}", attributes)


def _text(parent: etree._Element, text: str) -> None:
    from lxml import etree

    etree.SubElement(parent, f"{{{_XHTML}}}xhtml", nsmap={None: _XHTML}).text = text


def _type(parent: etree._Element, name: str) -> None:
    if name in _ELEMENTARY:
        _add(parent, name)
    else:
        _add(parent, "derived", name=name)


def _variables(parent: etree._Element, declared: str) -> None:
    for name, type_, start, comment in _VARIABLE.findall(declared):
        variable = _add(parent, "variable", name=name)
        _type(_add(variable, "type"), type_)
        if start:
            _value(_add(variable, "initialValue"), start)
        if comment:
            _text(_add(variable, "documentation"), comment.strip())


def _value(parent: etree._Element, text: str) -> None:
    """Add a number or Boolean, or an array whose elements may be arrays."""
    if not text.startswith("["):
        _add(parent, "simpleValue", value=text)
        return
    array = _add(parent, "arrayValue")
    for one in re.findall(r"\[.*?\]|[^,\s]+", text[1:-1]):
        _value(_add(array, "value"), one)
