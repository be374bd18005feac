"""The XML schemas of SSP, found in the packages that bring them along.

FMPy has those of SSP 1.0. Those of SSP 2.0 come with ``pyssp_standard``, an optional package:
without it, files of that version are checked for what is read of them only.
"""

from __future__ import annotations

from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from lxml import etree

_FILES = {
    "ssd": "Description",
    "ssv": "ParameterValues",
    "ssm": "ParameterMapping",
    "ssb": "SignalDictionary",
}


def violation(root: Any, part: str, version: str) -> tuple[int, str] | None:
    """Return line and text of the first breach of the schema.

    Parameters
    ----------
    root : element to check with all that is in it
    part : ``ssd``, ``ssv``, ``ssm`` or ``ssb``
    version : ``1.0`` or ``2.0``

    Returns
    -------
    None when it is valid, or when the schemas of that version are not installed
    """
    schema = _schema(part, version)
    if schema is None or schema.validate(root):
        return None
    error = schema.error_log[0]
    return error.line, error.message


@cache
def _schema(part: str, version: str) -> Any:
    package, folder = ("fmpy", "ssp/schema") if version == "1.0" else _SSP2
    found = find_spec(package)
    if found is None or found.origin is None:
        return None
    file = Path(found.origin).parent / folder / f"SystemStructure{_FILES[part]}.xsd"
    return etree.XMLSchema(file=str(file)) if file.is_file() else None


_SSP2 = ("pyssp_standard", "resources/ssp2")
