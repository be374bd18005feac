"""XML of descriptions that are written."""

import re
from collections.abc import Iterable
from xml.etree import ElementTree as ET

# A path of identifiers with indices (FMI 2.0.4, section 2.2.9).
_NAME = r"[A-Za-z_]\w*(?:\[\d+(?:,\d+)*\])?"
_PATH = rf"{_NAME}(?:\.{_NAME})*"
_STRUCTURED = re.compile(rf"{_PATH}|der\({_PATH}\)", re.ASCII)


def child(parent: ET.Element, tag: str, **attributes: object) -> ET.Element:
    """Append an element; attributes that are None are left out."""
    return ET.SubElement(parent, tag, {k: text(v) for k, v in attributes.items() if v is not None})


def text(value: object) -> str:
    """Return a value as XML schema writes it; floats keep every bit."""
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value) if isinstance(value, float) else str(value)


def naming(names: Iterable[str]) -> str:
    """Return the convention that names of variables follow."""
    return "structured" if all(map(_STRUCTURED.fullmatch, names)) else "flat"


def document(element: ET.Element) -> str:
    """Return the document as text, indented."""
    ET.indent(element)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(element, encoding="unicode")}\n'
