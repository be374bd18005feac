"""Rules about modelDescription.xml as an XML file; how the XML files of an FMU are read."""

import codecs
from dataclasses import dataclass
from functools import cache
from typing import Any

from lxml import etree

from stickslip.fmi.standard import standard_files
from stickslip.fmi.xml import Malformed, parse_xml
from stickslip.fmucheck.rules import Claims, error

Element = Any  # lxml ships no types


@dataclass(frozen=True)
class Document:
    """A parsed XML file and its path in the FMU; without a root, why it could not be parsed."""

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
    return etree.XMLSchema(etree.parse(str(standard_files("schema") / name)))


def violations(document: Document, schema: str) -> list[tuple[str, str]]:
    """Return place and message of each violation of a schema, by its file in the FMI project."""
    validator = _schema(schema)
    if document.root is None or validator.validate(document.root):
        return []
    found = [(one.line, " ".join(one.message.split())[:300]) for one in validator.error_log]
    return [(f"{document.name}, line {line}", message) for line, message in found]


def claimed_version(document: Document) -> str | None:
    """Return the fmiVersion that a description claims."""
    return None if document.root is None else document.root.get("fmiVersion")


def checked_version(document: Document) -> int | None:
    """Return 2 or 3 for a version that is checked, else None."""
    claimed = claimed_version(document) or ""
    return {"2": 2, "3": 3}.get(claimed.partition(".")[0])


@error("2.2", "2.4", "correct the XML")
def not_well_formed(document: Document) -> Claims:
    """modelDescription.xml is not well-formed XML."""
    if document.root is None:
        yield document.name, document.fault


@error("2.2", "2.4", "write the values themselves")
def document_type_declaration(document: Document) -> Claims:
    """It declares a document type, with which entities and files from outside come in."""
    if document.root is not None and document.root.getroottree().docinfo.doctype:
        yield document.name, "declares a document type; no entity of it is read"


@error("2.2", "2.4", "save it as UTF-8 and say so in the first line")
def wrong_encoding(document: Document) -> Claims:
    """It is not encoded in UTF-8."""
    if document.root is None:
        return
    encoding = document.root.getroottree().docinfo.encoding or "UTF-8"
    if codecs.lookup(encoding).name not in ("utf-8", "ascii"):
        yield document.name, f"is encoded in {encoding}"


@error("", "", "export it as FMI 2.0 or 3.0")
def fmi1_is_not_judged(document: Document) -> Claims:
    """An FMU of FMI 1.0, which is not supported."""
    if (claimed_version(document) or "").startswith("1."):
        what = "FMI 1.0 is not checked, though it can be run"
        yield document.name, f"{what}; nothing else was checked"


@error("2.2.1", "2.4.1", "write 2.0 or 3.0")
def unknown_version(document: Document) -> Claims:
    """The fmiVersion is missing or is not a version of FMI."""
    claimed = claimed_version(document)
    if document.root is not None and claimed not in ("1.0", "2.0", "3.0"):
        yield document.name, f'fmiVersion="{claimed}"; expected 2.0 or 3.0'


@error("2.2", "2.4", "write what the schema of the standard allows")
def schema_violation(document: Document) -> Claims:
    """It does not follow the XML schema of its version."""
    if version := checked_version(document):
        yield from violations(document, f"fmi{version}/fmi{version}ModelDescription.xsd")
