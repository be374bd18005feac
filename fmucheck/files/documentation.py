"""Rules about documentation, licences and further files."""

from __future__ import annotations

import re

from stickslip.fmucheck.finding import Severity
from stickslip.fmucheck.fmu import Fmu
from stickslip.fmucheck.rules import Claims, rule
from stickslip.fmucheck.xml import read_document

_ROOMS = ("binaries", "documentation", "extra", "resources", "sources", "terminalsAndIcons")
_MANIFEST = "http://fmi-standard.org/fmi-ls-manifest"
_DOMAIN = re.compile(r"[A-Za-z0-9-]+(\.[A-Za-z0-9_-]+)+")


@rule(Severity.NOTE, fmi2="2.3", fmi3="2.5.1.1", advice="add documentation/index.html")
def no_documentation(fmu: Fmu) -> Claims:
    """There is no documentation/index.html."""
    if "documentation/index.html" not in fmu.members:
        yield "documentation", "there is no index.html"


@rule(Severity.NOTE, fmi2="2.3", fmi3="2.5.1.1", advice="add documentation/licenses/license.txt")
def no_licence(fmu: Fmu) -> Claims:
    """Neither the description nor a file says under which licence the FMU is given."""
    if not fmu.below("documentation/licenses/") and not fmu.description.root.get("license"):
        yield "documentation/licenses", "nothing is said of a licence"


@rule(
    Severity.WARNING, fmi2="2.3", fmi3="2.5.1.1", advice="name the first file license.txt or .html"
)
def licence_without_entry(fmu: Fmu) -> Claims:
    """There is a folder of licences without license.txt, license.html or license.spdx."""
    names = fmu.below("documentation/licenses/")
    if names and not any(re.search(r"/license\.(txt|html|spdx)$", name) for name in names):
        yield "documentation/licenses", f"{names[0]}, but no license.txt, .html or .spdx"


@rule(Severity.NOTE, fmi2="2.3", fmi3="2.5.1", advice="move it below resources or extra")
def unexpected_file(fmu: Fmu) -> Claims:
    """A file lies where the standard foresees none."""
    known = {"modelDescription.xml"} | ({"model.png"} if fmu.description.version == 2 else set())
    for name in sorted(fmu.members):
        if name not in known and name.partition("/")[0] not in _ROOMS:
            yield name, "is nothing that the standard foresees"


@rule(Severity.WARNING, fmi2=None, fmi3="2.5.1.6", advice="use a folder such as extra/org.example")
def extra_without_domain(fmu: Fmu) -> Claims:
    """A folder below extra is not named after a domain, so that names can collide."""
    for folder in dict.fromkeys(name.split("/")[1] for name in fmu.below("extra/")):
        if not _DOMAIN.fullmatch(folder):
            yield f"extra/{folder}", "is not named in reverse domain notation"


@rule(Severity.ERROR, fmi2="", fmi3="2.6", advice="add it to the root element")
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
