"""XML from strangers: no entities, no network, no schema of theirs."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from lxml import etree

Element = Any  # lxml ships no types

MAX_BYTES = 2**27
"""Of one document, which takes 25 times as much memory; a million variables have 100 MB."""


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
    if len(text) > MAX_BYTES:
        return Document(name, b"", None, f"{len(text)} bytes; at most {MAX_BYTES} are read")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False)
    try:
        return Document(name, text, etree.fromstring(text, parser))
    except (etree.XMLSyntaxError, ValueError, LookupError) as fault:
        return Document(name, text, None, str(fault))


@cache
def _schema(name: str) -> Any:
    return etree.XMLSchema(etree.parse(str(schemas() / name)))


def schemas() -> Path:
    """Return the folder of the FMI project's schemas, which FMPy's wheel carries."""
    # FMPy itself is not imported: it takes a second, and this room judges without it.
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
