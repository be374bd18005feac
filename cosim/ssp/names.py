"""Namespaces, file names and media types of SSP 1.0 and 2.0; names across nested systems."""

from __future__ import annotations

NAMESPACES = {
    part: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for part, name in (
        ("ssd", "Description"),
        ("ssc", "Common"),
        ("ssv", "ParameterValues"),
        ("ssm", "ParameterMapping"),
        ("ssb", "SignalDictionary"),
    )
}
ROOTS = {
    "ssd": "ssd:SystemStructureDescription",
    "ssv": "ssv:ParameterSet",
    "ssm": "ssm:ParameterMapping",
    "ssb": "ssb:SignalDictionary",
}
VERSIONS = ("1.0", "2.0")
STRUCTURE = "SystemStructure.ssd"
FMU = "application/x-fmu-sharedlibrary"
NESTED = ("application/x-ssp-definition", "application/x-ssp-package")

# SSP has no place for a step size. libcosim has this one, and reads it from here.
ANNOTATION = "com.opensimulationplatform"
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"

# Between a nested system and its elements; a dot separates the variable.
SEPARATOR = "/"

Path = tuple[str, ...]
"""Names of elements, from the outermost system inwards; () is that system itself."""


def tag(name: str) -> str:
    """Return ``ssd:Name`` with its namespace, as lxml wants it."""
    prefix, _, local = name.partition(":")
    return f"{{{NAMESPACES[prefix]}}}{local}"


def component(path: Path) -> str:
    """Return the name of a component in a system without nesting: ``outer/inner``."""
    return SEPARATOR.join(path)


def path_of(name: str) -> Path:
    """Return where the component called ``outer/inner`` lies."""
    return tuple(name.split(SEPARATOR))
