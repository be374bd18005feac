"""XML files of an FMU, parsed or not, and what the schemas of the FMI project say of them."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from lxml import etree

from stickslip.fmi.xml import Malformed, parse_xml

Element = Any  # lxml ships no types


@dataclass(frozen=True)
class Document:
    """A parsed XML file, or why it could not be parsed.

    ``name`` is its path inside the FMU; ``root`` is ``None`` when there is a ``fault``.
    """

    name: str
    text: bytes
    root: Element | None
    fault: str = ""


def read_document(name: str, text: bytes) -> Document:
    """Parse a file; never raises for what is in it."""
    try:
        return Document(name, text, parse_xml(text, remarks=True, lenient=True))
    except Malformed as fault:
        message = str(fault).removesuffix("; export it again")  # the rule gives its own advice
        return Document(name, text, None, message)


@cache
def _schema(name: str) -> Any:
    return etree.XMLSchema(etree.parse(str(schemas() / name)))


def schemas() -> Path:
    """Return the folder of the FMI project's schemas, which FMPy's wheel carries."""
    # FMPy itself is not imported: it takes a second, and the checker works without it.
    spec = importlib.util.find_spec("fmpy")
    if spec is None or not spec.origin:
        raise ModuleNotFoundError("the FMI schemas are missing; run 'pip install fmpy'")
    return Path(spec.origin).parent / "schema"


def violations(document: Document, schema: str) -> list[tuple[str, str]]:
    """Return place and message of what an XML schema of the FMI project says against a document.

    Parameters
    ----------
    schema : file below ``schemas()``, such as ``fmi3/fmi3ModelDescription.xsd``
    """
    validator = _schema(schema)
    if document.root is None or validator.validate(document.root):
        return []
    return [
        (f"{document.name}, line {entry.line}", " ".join(entry.message.split())[:300])
        for entry in validator.error_log
    ]
