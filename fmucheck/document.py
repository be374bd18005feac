"""Rules about modelDescription.xml as an XML file."""

from __future__ import annotations

import codecs

from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule
from stickslip.fmucheck.xml import Document, violations

SCHEMAS = {2: "fmi2/fmi2ModelDescription.xsd", 3: "fmi3/fmi3ModelDescription.xsd"}


def claimed_version(document: Document) -> str | None:
    """Return the fmiVersion that a description claims."""
    return None if document.root is None else document.root.get("fmiVersion")


def checked_version(document: Document) -> int | None:
    """Return 2 or 3 for a version that is checked, else None."""
    claimed = claimed_version(document) or ""
    return {"2": 2, "3": 3}.get(claimed.partition(".")[0])


@rule(Severity.ERROR, fmi2="2.2", fmi3="2.4", advice="correct the XML")
def not_well_formed(document: Document) -> Claims:
    """modelDescription.xml is not well-formed XML."""
    if document.root is None:
        yield document.name, document.fault


@rule(Severity.ERROR, fmi2="2.2", fmi3="2.4", advice="write the values themselves")
def document_type_declaration(document: Document) -> Claims:
    """It declares a document type, with which entities and files from outside come in."""
    if document.root is not None and document.root.getroottree().docinfo.doctype:
        yield document.name, "declares a document type; no entity of it is read"


@rule(
    Severity.ERROR, fmi2="2.2", fmi3="2.4", advice="save it as UTF-8 and say so in the first line"
)
def wrong_encoding(document: Document) -> Claims:
    """It is not encoded in UTF-8."""
    if document.root is None:
        return
    encoding = document.root.getroottree().docinfo.encoding or "UTF-8"
    if codecs.lookup(encoding).name not in ("utf-8", "ascii"):
        yield document.name, f"is encoded in {encoding}"


@rule(Severity.ERROR, fmi2="", fmi3="", advice="export it as FMI 2.0 or 3.0")
def fmi1_is_not_judged(document: Document) -> Claims:
    """An FMU of FMI 1.0, which is not supported."""
    if (claimed_version(document) or "").startswith("1."):
        yield document.name, "FMI 1.0 is not supported; nothing else was checked"


@rule(Severity.ERROR, fmi2="2.2.1", fmi3="2.4.1", advice="write 2.0 or 3.0")
def unknown_version(document: Document) -> Claims:
    """The fmiVersion is missing, or is no version of FMI."""
    claimed = claimed_version(document)
    if document.root is not None and claimed not in ("1.0", "2.0", "3.0"):
        yield document.name, f'fmiVersion="{claimed}"; expected 2.0 or 3.0'


@rule(Severity.ERROR, fmi2="2.2", fmi3="2.4", advice="write what the schema of the standard allows")
def schema_violation(document: Document) -> Claims:
    """It does not follow the XML schema of its version."""
    version = checked_version(document)
    if version:
        yield from violations(document, SCHEMAS[version])
