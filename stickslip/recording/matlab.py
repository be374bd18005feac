"""Logs as MAT files."""

from __future__ import annotations

import io
import struct
import zlib
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import scipy.io
from scipy.io.matlab import MatReadError

from stickslip.errors import RecordingError
from stickslip.measurement import Array
from stickslip.recording.table import LogTable

_BROKEN = (
    ValueError,
    TypeError,
    LookupError,
    AttributeError,
    ArithmeticError,
    EOFError,
    OSError,
    MemoryError,
    NotImplementedError,
    RecursionError,
    struct.error,
    zlib.error,
    MatReadError,
)
"""What scipy raises, depending on the byte that is wrong."""


def read_matlab(path: str, data: bytes) -> LogTable:
    """Read the vectors and scalars of a MAT file; fields of structs are called ``struct.field``.

    Raises
    ------
    RecordingError
        When it cannot be read or holds no vector of numbers.
    """
    if data[:20].startswith(b"MATLAB 7.3") or data.startswith(b"\x89HDF"):
        content = _hdf5(path, data)
    else:
        try:
            content = scipy.io.loadmat(io.BytesIO(data))  # type: ignore[arg-type] # the stubs err
        except _BROKEN as error:
            said = " ".join(str(error).split())[:80] or type(error).__name__
            raise RecordingError(
                f"{path}: not a MAT file of version 5, or damaged ({said}); save it as text or -v7"
            ) from None
    numbers: dict[str, Array] = {}
    scalars: dict[str, float] = {}
    faults: dict[str, str] = {}
    for name, value in _flat({k: v for k, v in content.items() if not k.startswith("__")}):
        if not _is_numeric(value):
            kind = "text" if value.dtype.kind in "US" else f"a {value.dtype.name} array"
            faults[name] = f"expected a vector of numbers, got {kind}"
        elif value.size == 1:
            scalars[name] = float(value.ravel()[0])
        elif value.ndim == 2 and min(value.shape) > 1:  # one signal a column
            matrix = value if value.shape[0] >= value.shape[1] else value.T
            for k, column in enumerate(matrix.T, start=1):
                numbers[f"{name}({k})"] = column.astype(np.float64)
        elif value.ndim <= 2 and value.size:
            numbers[name] = value.ravel().astype(np.float64)
        else:
            faults[name] = f"expected a vector, got an array {value.shape}"
    if not numbers:
        found = ", ".join(sorted([*scalars, *faults])[:8]) or "nothing"
        raise RecordingError(f"{path}: no vectors of numbers; there is {found}")
    return LogTable(path, (*numbers, *faults), numbers, faults=faults, scalars=scalars)


def _flat(content: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield arrays by name; a struct of one element gives its fields."""
    for name, value in content.items():
        array = np.asarray(value)
        if array.dtype.names and array.size == 1:
            record = array.ravel()[0]
            fields = {field: record[field] for field in array.dtype.names}
            yield from _flat(fields, f"{prefix}{name}.")
        else:
            yield prefix + name, array


def _is_numeric(array: Any) -> bool:
    return array.dtype.kind in "fiub"


def _hdf5(path: str, data: bytes) -> dict[str, Any]:
    """Return the arrays of a MAT file of version 7.3."""
    try:
        import h5py
    except ImportError:
        raise RecordingError(
            f"{path}: a MAT file of version 7.3; save it with save(..., '-v7'), or install h5py"
        ) from None
    content: dict[str, Any] = {}

    def keep(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("#"):
            content[name.replace("/", ".")] = item[()]

    try:
        with h5py.File(io.BytesIO(data), "r") as file:
            file.visititems(keep)
    except _BROKEN as error:
        raise RecordingError(f"{path}: a damaged MAT file of version 7.3 ({error})") from None
    return content
