"""Rules about terminals and icons."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.fmu import Fmu
from stickslip.fmucheck.rules import Claims, rule
from stickslip.fmucheck.xml import Document, Element, read_document, violations

TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
_NAMES = ("variableName", "inStreamVariableName", "outStreamVariableName")
_CONNECTED = ("input", "output", "parameter", "calculatedParameter")


def _document(fmu: Fmu) -> Document | None:
    return read_document(TERMINALS, fmu.bytes(TERMINALS)) if TERMINALS in fmu.members else None


def _terminals(fmu: Fmu) -> Iterator[Element]:
    document = _document(fmu)
    if document and document.root is not None:
        yield from document.root.iter("Terminal")


def _place(element: Element) -> str:
    return f"{TERMINALS} (line {element.sourceline})"


@rule(Severity.ERROR, fmi2="2.3", fmi3="2.4.9", advice="follow fmi3TerminalsAndIcons.xsd")
def bad_terminals_file(fmu: Fmu) -> Claims:
    """terminalsAndIcons.xml does not follow its schema, or is of another version."""
    document = _document(fmu)
    if document is None:
        return
    if document.root is None:
        yield TERMINALS, document.fault
        return
    yield from violations(document, "fmi3/fmi3TerminalsAndIcons.xsd")
    version = document.root.get("fmiVersion")
    if fmu.description.version == 3 and version != fmu.description.root.get("fmiVersion"):
        yield TERMINALS, f"fmiVersion={version} differs from modelDescription.xml"


@rule(Severity.WARNING, fmi2="2.3", fmi3="2.5.1.2", advice="move it to terminalsAndIcons")
def misplaced_terminals(fmu: Fmu) -> Claims:
    """terminalsAndIcons.xml lies where no importer looks for it."""
    for name in fmu.members:
        if (
            name.endswith("terminalsAndIcons.xml")
            and name != TERMINALS
            and not name.startswith("extra/")
        ):
            yield name, f"expected at {TERMINALS}"


@rule(Severity.ERROR, fmi2="2.3", fmi3="2.4.9", advice="name a variable of modelDescription.xml")
def terminal_of_unknown_variable(fmu: Fmu) -> Claims:
    """A terminal refers to a variable that does not exist."""
    known = {v.name for v in fmu.description.variables}
    known |= {a.get("name", "") for v in fmu.description.variables for a in v.aliases}
    for terminal in _terminals(fmu):
        for member in terminal:
            for attribute in _NAMES:
                name = member.get(attribute)
                if name is not None and name not in known:
                    yield _place(member), f"terminal {terminal.get('name')}: no variable {name}"


@rule(Severity.ERROR, fmi2="2.3", fmi3="2.4.9", advice="give each a name of its own")
def terminal_names(fmu: Fmu) -> Claims:
    """Terminals of one level, or members of one terminal, share a name; or a plug's has none."""
    document = _document(fmu)
    if document is None or document.root is None:
        return
    levels = [*document.root.iter("Terminals"), *document.root.iter("Terminal")]
    for level in levels:
        for name, count in Counter(t.get("name") for t in level.iterfind("Terminal")).items():
            if count > 1:
                yield _place(level), f"{count} terminals are named {name}"
    for terminal in _terminals(fmu):
        names = [m.get("memberName") for m in terminal.iterfind("TerminalMemberVariable")]
        for name, count in Counter(n for n in names if n is not None).items():
            if count > 1:
                yield _place(terminal), f"{count} members are named {name}"
        if terminal.get("matchingRule") in ("plug", "bus") and None in names:
            yield (
                _place(terminal),
                f"a member has no memberName in a {terminal.get('matchingRule')}",
            )


@rule(Severity.WARNING, fmi2="2.3", fmi3="2.4.9", advice="use inputs, outputs and parameters")
def terminal_of_local_variable(fmu: Fmu) -> Claims:
    """A member that is a signal or flow is a variable that cannot be connected."""
    causality = {v.name: v.causality for v in fmu.description.variables}
    for terminal in _terminals(fmu):
        for member in terminal.iterfind("TerminalMemberVariable"):
            name = member.get("variableName", "")
            if member.get("variableKind") in ("signal", "inflow", "outflow") and (
                causality.get(name, "input") not in _CONNECTED
            ):
                yield _place(member), f"{name} has causality {causality[name]}"


@rule(Severity.ERROR, fmi2="2.3", fmi3="2.4.9", advice="pack the picture as PNG")
def icon_missing(fmu: Fmu) -> Claims:
    """An icon that is referred to is not there, or is SVG without the PNG it must come with."""
    for graphic in _graphics(fmu):
        name = f"terminalsAndIcons/{graphic.get('iconBaseName')}.png"
        if name not in fmu.members:
            yield _place(graphic), f"{name} is not in the FMU"
    document = _document(fmu)
    icon = (
        document.root.find("GraphicalRepresentation/Icon")
        if document and document.root is not None
        else None
    )
    if icon is not None and "terminalsAndIcons/icon.png" not in fmu.members:
        yield _place(icon), "terminalsAndIcons/icon.png is not in the FMU"
    for svg in ("terminalsAndIcons/icon.svg", "documentation/diagram.svg"):
        png = svg.removesuffix("svg") + "png"
        if svg in fmu.members and png not in fmu.members:
            yield svg, f"comes without {png}"


def _graphics(fmu: Fmu) -> Iterator[Element]:
    for terminal in _terminals(fmu):
        yield from terminal.iterfind("TerminalGraphicalRepresentation")


@rule(Severity.WARNING, fmi2="2.3", fmi3="2.5.1", advice="save it as PNG")
def picture_is_no_png(fmu: Fmu) -> Claims:
    """A picture is named .png, but is none."""
    for name in fmu.members:
        shown = name == "model.png" or name.startswith(("terminalsAndIcons/", "documentation/"))
        if shown and name.endswith(".png") and not fmu.bytes(name).startswith(b"\x89PNG\r\n\x1a\n"):
            yield name, "does not begin as a PNG file does"
