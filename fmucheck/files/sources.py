"""Rules about source code and its build description."""

from __future__ import annotations

import posixpath
from collections import Counter
from collections.abc import Iterator

from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.fmu import Fmu
from stickslip.fmucheck.rules import Claims, rule
from stickslip.fmucheck.xml import Document, read_document, violations

BUILD = "sources/buildDescription.xml"
_HEADERS = ("fmi3PlatformTypes.h", "fmi3FunctionTypes.h", "fmi3Functions.h")


def _build(fmu: Fmu) -> Document | None:
    return read_document(BUILD, fmu.bytes(BUILD)) if BUILD in fmu.members else None


def _listed(fmu: Fmu) -> Iterator[tuple[str, str]]:
    """Yield where a source file is listed, and its name below sources/."""
    for interface in fmu.description.interfaces:
        for name in interface.sources:
            yield interface.place, name
    build = _build(fmu)
    if build and build.root is not None:
        for file in build.root.iter("SourceFile"):
            yield f"{BUILD} (line {file.sourceline})", file.get("name", "")


@rule(Severity.ERROR, fmi2="2.3", fmi3="2.5.1.3", advice="pack it, or take it off the list")
def source_missing(fmu: Fmu) -> Claims:
    """A source file is listed that is not in the FMU."""
    for place, name in dict.fromkeys(_listed(fmu)):
        if posixpath.normpath(f"sources/{name}") not in fmu.members:
            yield place, f"sources/{name} is not in the FMU"


@rule(Severity.ERROR, fmi2="2.3", fmi3="2.5.1.3", advice="follow fmi3BuildDescription.xsd")
def bad_build_description(fmu: Fmu) -> Claims:
    """buildDescription.xml does not follow its schema."""
    build = _build(fmu)
    if build and build.root is None:
        yield BUILD, build.fault
    elif build:
        yield from violations(build, "fmi3/fmi3BuildDescription.xsd")


@rule(
    Severity.ERROR, fmi2="2.3", fmi3="2.5.1.3", advice="use a modelIdentifier, each platform once"
)
def bad_build_configuration(fmu: Fmu) -> Claims:
    """A build configuration is for an unknown modelIdentifier, or for a platform twice."""
    build = _build(fmu)
    if not build or build.root is None:
        return
    made = [
        (c.get("modelIdentifier", ""), c.get("platform"))
        for c in build.root.iter("BuildConfiguration")
    ]
    for identifier in dict.fromkeys(name for name, _ in made):
        if identifier not in fmu.identifiers:
            yield BUILD, f"modelIdentifier={identifier} is none of modelDescription.xml"
    for (identifier, platform), count in Counter(made).items():
        if count > 1:
            yield BUILD, f"{count} configurations of {identifier} for {platform or 'any platform'}"


@rule(Severity.ERROR, fmi2="2.3", fmi3="2.5.1.3", advice="say which compiler takes them")
def options_without_compiler(fmu: Fmu) -> Claims:
    """A set of source files has compilerOptions, but no compiler."""
    build = _build(fmu)
    for files in build.root.iter("SourceFileSet") if build and build.root is not None else ():
        if "compilerOptions" in files.attrib and "compiler" not in files.attrib:
            yield f"{BUILD} (line {files.sourceline})", f"{files.get('compilerOptions')!r}"


@rule(Severity.ERROR, fmi2=None, fmi3="2.5.1.3", advice="add sources/buildDescription.xml")
def sources_without_build_description(fmu: Fmu) -> Claims:
    """There are sources, but nothing says how to build them."""
    if fmu.below("sources/") and BUILD not in fmu.members:
        yield "sources", "there is no buildDescription.xml"


@rule(Severity.WARNING, fmi2="2.3", fmi3=None, advice="list them under SourceFiles")
def sources_not_listed(fmu: Fmu) -> Claims:
    """There are C sources, but neither SourceFiles nor a build description lists any."""
    code = [name for name in fmu.below("sources/") if name.endswith((".c", ".cpp", ".cc"))]
    if code and BUILD not in fmu.members and not any(i.sources for i in fmu.description.interfaces):
        yield "sources", f"{len(code)} files, and no list of what to compile"


@rule(Severity.NOTE, fmi2=None, fmi3="2.5.1.3", advice="leave them out; importers bring their own")
def headers_of_the_standard(fmu: Fmu) -> Claims:
    """The headers of FMI are among the sources."""
    for name in fmu.below("sources/"):
        if posixpath.basename(name) in _HEADERS:
            yield name, "is a header of the standard"
