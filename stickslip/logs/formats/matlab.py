"""Logs as MAT files."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from stickslip.cosim.signals.parquet import MOST_VALUES
from stickslip.errors import RecordingError
from stickslip.logs.mat5 import DamagedError, Other, read_variables
from stickslip.logs.table import LogTable
from stickslip.servo.measurement import Array


def recognises(data: bytes, suffix: str) -> bool:
    """Tell whether a log is of this format."""
    return data.startswith((b"MATLAB ", b"\x89HDF")) or suffix == ".mat"


def read(path: str, data: bytes) -> LogTable:
    """Read the vectors and scalars of a MAT file; fields of structs are called ``struct.field``.

    Raises
    ------
    RecordingError
        When it cannot be read or holds no vector of numbers.
    """
    if data.startswith((b"MATLAB 7.3", b"\x89HDF")):
        content = _hdf5(path, data)
    else:
        try:
            content = read_variables(data)
        except DamagedError as error:
            raise RecordingError(
                f"{path}: not a MAT file of version 5, or damaged ({error}); save it with "
                "save(..., '-v7')"
            ) from None
    numbers: dict[str, Array] = {}
    scalars: dict[str, float] = {}
    faults: dict[str, str] = {}
    for name, found in _flat(content):
        if isinstance(found, Other):
            faults[name] = f"expected a vector of numbers, got {found.kind}"
            continue
        with np.errstate(invalid="ignore"):  # odd kinds of NaN
            value = found.astype(np.float64)
        if value.size == 1:
            scalars[name] = float(value.ravel()[0])
        elif value.ndim == 2 and min(value.shape) > 1:  # one signal a column
            matrix = value if value.shape[0] >= value.shape[1] else value.T
            for k, column in enumerate(matrix.T, start=1):
                numbers[f"{name}({k})"] = column
        elif value.ndim <= 2 and value.size:
            numbers[name] = value.ravel()
        else:
            faults[name] = f"expected a vector, got an array {value.shape}"
    if not numbers:
        found = ", ".join(sorted([*scalars, *faults])[:8]) or "nothing"
        raise RecordingError(f"{path}: no vectors of numbers; there is {found}")
    return LogTable(path, (*numbers, *faults), numbers, faults=faults, scalars=scalars)


def _flat(content: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Yield arrays by name; a struct gives its fields."""
    for name, value in content.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield prefix + name, value


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
            if item.size > MOST_VALUES:
                raise ValueError(f"{item.size} values, at most {MOST_VALUES} are read")
            array = np.asarray(item[()])
            numeric = array.dtype.kind in "fiub" and "MATLAB_empty" not in item.attrs
            content[name.replace("/", ".")] = array if numeric else Other(f"{array.dtype}")

    try:
        with h5py.File(io.BytesIO(data), "r") as file:
            file.visititems(keep)
    except (OSError, ValueError, RuntimeError, KeyError, TypeError) as error:
        said = " ".join(str(error).split())[:80]
        raise RecordingError(f"{path}: a damaged MAT file of version 7.3 ({said})") from None
    return content
