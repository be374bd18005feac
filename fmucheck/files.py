"""Rules about sources, terminals and icons, documentation and licences."""

import posixpath
import re
from collections.abc import Iterator

from stickslip.fmucheck.description.model import Fmu, repeated
from stickslip.fmucheck.document import Document, Element, read_document, violations
from stickslip.fmucheck.rules import Claims, error, note, warning

BUILD = "sources/buildDescription.xml"
_HEADERS = ("fmi3PlatformTypes.h", "fmi3FunctionTypes.h", "fmi3Functions.h")


def _document(fmu: Fmu, name: str) -> Document | None:
    return read_document(name, fmu.bytes(name)) if name in fmu.members else None


def _all(fmu: Fmu, name: str, *tags: str) -> Iterator[Element]:
    """Yield the elements with these tags in a file, none if it is missing or damaged."""
    document = _document(fmu, name)
    if document and document.root is not None:
        for tag in tags:
            yield from document.root.iter(tag)


def _faults(fmu: Fmu, name: str, schema: str) -> Claims:
    if document := _document(fmu, name):
        fault = [(name, document.fault)] if document.root is None else []
        yield from fault or violations(document, f"fmi3/{schema}.xsd")


@error("2.3", "2.5.1.3", "pack it, or take it off the list")
def source_missing(fmu: Fmu) -> Claims:
    """A source file is listed that is not in the FMU."""
    listed = [(each.place, name) for each in fmu.description.interfaces for name in each.sources]
    files = _all(fmu, BUILD, "SourceFile")
    listed += [(f"{BUILD} (line {each.sourceline})", each.get("name", "")) for each in files]
    for place, name in dict.fromkeys(listed):
        if posixpath.normpath(f"sources/{name}") not in fmu.members:
            yield place, f"sources/{name} is not in the FMU"


@error("2.3", "2.5.1.3", "follow fmi3BuildDescription.xsd")
def bad_build_description(fmu: Fmu) -> Claims:
    """buildDescription.xml does not follow its schema."""
    yield from _faults(fmu, BUILD, "fmi3BuildDescription")


@error("2.3", "2.5.1.3", "use a modelIdentifier, each platform once")
def bad_build_configuration(fmu: Fmu) -> Claims:
    """A build configuration is for an unknown modelIdentifier, or for a platform twice."""
    each = _all(fmu, BUILD, "BuildConfiguration")
    made = [(c.get("modelIdentifier", ""), c.get("platform")) for c in each]
    for identifier in dict.fromkeys(name for name, _ in made):
        if identifier not in fmu.identifiers:
            yield BUILD, f"modelIdentifier={identifier} is not in modelDescription.xml"
    for (identifier, platform), count in repeated(made):
        yield BUILD, f"{count} configurations of {identifier} for {platform or 'any platform'}"


@error("2.3", "2.5.1.3", "say which compiler takes them")
def options_without_compiler(fmu: Fmu) -> Claims:
    """A set of source files has compilerOptions, but no compiler."""
    for files in _all(fmu, BUILD, "SourceFileSet"):
        if "compilerOptions" in files.attrib and "compiler" not in files.attrib:
            yield f"{BUILD} (line {files.sourceline})", f"{files.get('compilerOptions')!r}"


@error(None, "2.5.1.3", "add sources/buildDescription.xml")
def sources_without_build_description(fmu: Fmu) -> Claims:
    """There are sources without a build description."""
    if fmu.below("sources/") and BUILD not in fmu.members:
        yield "sources", "there is no buildDescription.xml"


@warning("2.3", None, "list them under SourceFiles")
def sources_not_listed(fmu: Fmu) -> Claims:
    """There are C sources, but neither SourceFiles nor a build description lists any."""
    code = [name for name in fmu.below("sources/") if name.endswith((".c", ".cpp", ".cc"))]
    if code and BUILD not in fmu.members and not any(i.sources for i in fmu.description.interfaces):
        yield "sources", f"{len(code)} files, and no list of what to compile"


@note(None, "2.5.1.3", "leave them out; importers bring their own")
def headers_of_the_standard(fmu: Fmu) -> Claims:
    """The headers of FMI are among the sources."""
    for name in fmu.below("sources/"):
        if posixpath.basename(name) in _HEADERS:
            yield name, "is a header of the standard"


TERMINALS = "terminalsAndIcons/terminalsAndIcons.xml"
_NAMES = ("variableName", "inStreamVariableName", "outStreamVariableName")
_CONNECTED = ("input", "output", "parameter", "calculatedParameter")


def _place(element: Element) -> str:
    return f"{TERMINALS} (line {element.sourceline})"


@error("2.3", "2.4.9", "follow fmi3TerminalsAndIcons.xsd")
def bad_terminals_file(fmu: Fmu) -> Claims:
    """terminalsAndIcons.xml does not follow its schema, or is of another version."""
    yield from _faults(fmu, TERMINALS, "fmi3TerminalsAndIcons")
    for root in _all(fmu, TERMINALS, "fmiTerminalsAndIcons"):
        version = root.get("fmiVersion")
        if fmu.description.version == 3 and version != fmu.description.root.get("fmiVersion"):
            yield TERMINALS, f"fmiVersion={version} differs from modelDescription.xml"


@warning("2.3", "2.5.1.2", "move it to terminalsAndIcons")
def misplaced_terminals(fmu: Fmu) -> Claims:
    """terminalsAndIcons.xml lies where no importer looks for it."""
    for name in fmu.members:
        if name.endswith("terminalsAndIcons.xml") and not name.startswith((TERMINALS, "extra/")):
            yield name, f"expected at {TERMINALS}"


@error("2.3", "2.4.9", "name a variable of modelDescription.xml")
def terminal_of_unknown_variable(fmu: Fmu) -> Claims:
    """A terminal refers to a variable that does not exist."""
    known = {v.name for v in fmu.description.variables}
    known |= {a.get("name", "") for v in fmu.description.variables for a in v.aliases}
    for terminal in _all(fmu, TERMINALS, "Terminal"):
        for member in terminal:
            for attribute in _NAMES:
                name = member.get(attribute)
                if name is not None and name not in known:
                    yield _place(member), f"terminal {terminal.get('name')}: no variable {name}"


@error("2.3", "2.4.9", "give each a name of its own")
def terminal_names(fmu: Fmu) -> Claims:
    """Terminals of one level, or members of one terminal, share a name; or a plug's has none."""
    for level in _all(fmu, TERMINALS, "Terminals", "Terminal"):
        for name, count in repeated(t.get("name") for t in level.iterfind("Terminal")):
            yield _place(level), f"{count} terminals are named {name}"
    for terminal in _all(fmu, TERMINALS, "Terminal"):
        names = [m.get("memberName") for m in terminal.iterfind("TerminalMemberVariable")]
        for name, count in repeated(names):
            yield _place(terminal), f"{count} members are named {name}"
        rule = terminal.get("matchingRule")
        if rule in ("plug", "bus") and None in names:
            yield _place(terminal), f"a member has no memberName in a {rule}"


@warning("2.3", "2.4.9", "use inputs, outputs and parameters")
def terminal_of_local_variable(fmu: Fmu) -> Claims:
    """A member that is a signal or flow is a variable that cannot be connected."""
    causality = {v.name: v.causality for v in fmu.description.variables}
    for terminal in _all(fmu, TERMINALS, "Terminal"):
        for member in terminal.iterfind("TerminalMemberVariable"):
            name = member.get("variableName", "")
            if member.get("variableKind") in ("signal", "inflow", "outflow") and (
                causality.get(name, "input") not in _CONNECTED
            ):
                yield _place(member), f"{name} has causality {causality[name]}"


@error("2.3", "2.4.9", "pack the picture as PNG")
def icon_missing(fmu: Fmu) -> Claims:
    """An icon that is referred to is not there, or is SVG without the PNG it must come with."""
    for graphic in _all(fmu, TERMINALS, "TerminalGraphicalRepresentation"):
        name = f"terminalsAndIcons/{graphic.get('iconBaseName')}.png"
        if name not in fmu.members:
            yield _place(graphic), f"{name} is not in the FMU"
    for icon in _all(fmu, TERMINALS, "Icon"):
        if "terminalsAndIcons/icon.png" not in fmu.members:
            yield _place(icon), "terminalsAndIcons/icon.png is not in the FMU"
    for svg in ("terminalsAndIcons/icon.svg", "documentation/diagram.svg"):
        png = svg.removesuffix("svg") + "png"
        if svg in fmu.members and png not in fmu.members:
            yield svg, f"comes without {png}"


@warning("2.3", "2.5.1", "save it as PNG")
def picture_is_no_png(fmu: Fmu) -> Claims:
    """A picture is named .png, but is not a PNG file."""
    for name in fmu.members:
        shown = name == "model.png" or name.startswith(("terminalsAndIcons/", "documentation/"))
        if shown and name.endswith(".png") and not fmu.bytes(name).startswith(b"\x89PNG\r\n\x1a\n"):
            yield name, "does not begin as a PNG file does"


_ROOMS = ("binaries", "documentation", "extra", "resources", "sources", "terminalsAndIcons")
_MANIFEST = "http://fmi-standard.org/fmi-ls-manifest"
_DOMAIN = re.compile(r"[A-Za-z0-9-]+(\.[A-Za-z0-9_-]+)+")


@note("2.3", "2.5.1.1", "add documentation/index.html")
def no_documentation(fmu: Fmu) -> Claims:
    """There is no documentation/index.html."""
    if "documentation/index.html" not in fmu.members:
        yield "documentation", "there is no index.html"


@note("2.3", "2.5.1.1", "add documentation/licenses/license.txt")
def no_licence(fmu: Fmu) -> Claims:
    """Neither the description nor a file states a licence."""
    if not fmu.below("documentation/licenses/") and not fmu.description.root.get("license"):
        yield "documentation/licenses", "no licence is stated"


@warning("2.3", "2.5.1.1", "name the first file license.txt or .html")
def licence_without_entry(fmu: Fmu) -> Claims:
    """There is a folder of licences without license.txt, license.html or license.spdx."""
    names = fmu.below("documentation/licenses/")
    if names and not any(re.search(r"/license\.(txt|html|spdx)$", name) for name in names):
        yield "documentation/licenses", f"{names[0]}, but no license.txt, .html or .spdx"


@note("2.3", "2.5.1", "move it below resources or extra")
def unexpected_file(fmu: Fmu) -> Claims:
    """A file lies in a place that the standard does not define."""
    known = {"modelDescription.xml"} | ({"model.png"} if fmu.description.version == 2 else set())
    for name in sorted(fmu.members):
        if name not in known and name.partition("/")[0] not in _ROOMS:
            yield name, "is not in a place that the standard defines"


@warning(None, "2.5.1.6", "use a folder such as extra/org.example")
def extra_without_domain(fmu: Fmu) -> Claims:
    """A folder below extra is not named after a domain, so that names can collide."""
    for folder in dict.fromkeys(name.split("/")[1] for name in fmu.below("extra/")):
        if not _DOMAIN.fullmatch(folder):
            yield f"extra/{folder}", "is not named in reverse domain notation"


@error(None, "2.6", "add it to the root element")
def bad_layered_standard(fmu: Fmu) -> Claims:
    """The manifest of a layered standard does not say its name, version and description."""
    for name in fmu.below("extra/"):
        if name.endswith("/fmi-ls-manifest.xml"):
            document = read_document(name, fmu.bytes(name))
            if document.root is None:
                yield name, document.fault
                continue
            # The root element is up to the layered standard; its attributes are not.
            for attribute in ("name", "version", "description"):
                if document.root.get(f"{{{_MANIFEST}}}fmi-ls-{attribute}") is None:
                    yield name, f"has no fmi-ls-{attribute}"
