"""Logs as MAT files up to version 7, with structures and cells."""

import io
from typing import Any

import numpy as np

TITLE = "MAT"
SUFFIXES = (".mat",)
BEGINS = (b"MATLAB 5",)


def contents(data: bytes) -> dict[str, Any]:
    """Return the variables: structures as mappings, arrays of them and cells as lists."""
    from scipy.io import loadmat

    variables = loadmat(io.BytesIO(data), chars_as_strings=True).items()  # type: ignore[arg-type]
    found = {name: value for name, value in variables if not name.startswith("__")}
    return {_name(name, value): _plain(value) for name, value in found.items()}


def _name(name: str, found: Any) -> str:
    """Return the name of a variable; SciPy before 1.18 has that of an object in the object."""
    inside = type(found).__name__ == "MatlabOpaque" and "s0" in found.dtype.names
    return _decoded(found.ravel()["s0"][0]) if inside else name


def _decoded(text: Any) -> str:
    return text.decode("latin-1") if isinstance(text, bytes) else str(text)


def _plain(found: Any) -> Any:
    if not isinstance(found, np.ndarray):
        return found
    kind = found.dtype.kind
    if type(found).__name__ == "MatlabOpaque":
        field = "s2" if "s2" in found.dtype.names else "_Class"
        cls = _decoded(found.ravel()[field][0])
        return f"a MATLAB object ({cls}), which only MATLAB reads; save a structure with time"
    if kind == "V" and found.dtype.names:
        each = [
            {name: _plain(value) for name, value in zip(found.dtype.names, one, strict=True)}
            for one in found.ravel()
        ]
        return each[0] if len(each) == 1 else each
    if kind == "O":
        return [_plain(value) for value in found.ravel()]
    if kind == "U":
        return str(found.ravel()[0]) if found.size == 1 else ""
    return found
