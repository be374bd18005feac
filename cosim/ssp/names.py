"""Namespaces and file names of SSP 1.0, and the annotation that carries the step size."""

from __future__ import annotations

from pathlib import Path

import fmpy

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
SCHEMAS = Path(fmpy.__file__).parent / "ssp" / "schema"
STRUCTURE = "SystemStructure.ssd"

# SSP has no place for a step size. libcosim has this one, and reads it from here.
ANNOTATION = "com.opensimulationplatform"
OSP = "http://opensimulationplatform.com/SSP/OSPAnnotations"


def tag(name: str) -> str:
    """Return ``ssd:Name`` with its namespace, as lxml wants it."""
    prefix, _, local = name.partition(":")
    return f"{{{NAMESPACES[prefix]}}}{local}"
