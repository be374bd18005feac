"""Rules about what the FMU calls itself and which interfaces it offers."""

from __future__ import annotations

import re

from stickslip.fmucheck.description.model import Description
from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.rules import Claims, rule

_C_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_UTC = re.compile(r"\d{4}-\d{2}-\d{2}T\d{2}:\d{2}:\d{2}(\.\d+)?Z")
_FILE = "modelDescription.xml"


@rule(Severity.ERROR, fmi2="2.2.1", fmi3="2.4.1", advice="declare an interface that the binary has")
def no_interface(description: Description) -> Claims:
    """There is neither ModelExchange nor CoSimulation nor ScheduledExecution."""
    if not description.interfaces:
        yield _FILE, "no interface is declared"


@rule(Severity.ERROR, fmi2="2.1.1", fmi3="2.2", advice="use letters, digits and _, no digit first")
def bad_model_identifier(description: Description) -> Claims:
    """The modelIdentifier is no name in C; with path parts it even points outside the FMU."""
    for interface in description.interfaces:
        if not _C_NAME.fullmatch(interface.identifier):
            yield interface.place, f'modelIdentifier="{interface.identifier}" is not a C name'


@rule(Severity.WARNING, fmi2="2.2.1", fmi3="2.4.1", advice="write a hash of the interface")
def empty_token(description: Description) -> Claims:
    """The guid or instantiationToken is empty, so nothing ties description and binary."""
    if not description.token.strip():
        yield _FILE, f"{'guid' if description.version == 2 else 'instantiationToken'} is empty"


@rule(Severity.WARNING, fmi2="2.2.1", fmi3="2.4.1", advice="name the model")
def empty_model_name(description: Description) -> Claims:
    """The modelName is empty."""
    if not description.root.get("modelName", "").strip():
        yield _FILE, "modelName is empty"


@rule(Severity.WARNING, fmi2="2.2.1", fmi3="2.4.1", advice="write YYYY-MM-DDThh:mm:ssZ")
def date_not_utc(description: Description) -> Claims:
    """The generationDateAndTime is not written as UTC with Z."""
    date = description.root.get("generationDateAndTime")
    if date is not None and not _UTC.fullmatch(date.strip()):
        yield _FILE, f'generationDateAndTime="{date}"'


@rule(Severity.NOTE, fmi2="2.2.1", fmi3="2.4.1", advice="fill them in; they help whoever gets it")
def missing_metadata(description: Description) -> Claims:
    """Attributes that say where the FMU comes from are missing."""
    wanted = ("description", "author", "version", "license", "generationTool")
    missing = [name for name in wanted if not description.root.get(name)]
    if missing:
        yield _FILE, f"says nothing of {', '.join(missing)}"


@rule(Severity.NOTE, fmi2="2.2.7", fmi3="2.4.7", advice="describe them")
def undescribed_variables(description: Description) -> Claims:
    """Inputs, outputs or parameters have no description."""
    shown = ("input", "output", "parameter", "structuralParameter")
    bare = [
        v.name for v in description.variables if v.causality in shown and not v.get("description")
    ]
    if bare:
        yield _FILE, f"{len(bare)} inputs, outputs and parameters have no description, as {bare[0]}"
