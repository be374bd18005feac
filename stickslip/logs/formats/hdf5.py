"""Logs as HDF5 files, MATLAB's version 7.3 among them."""

import io
from typing import Any

import numpy as np

TITLE = "HDF5 or MATLAB 7.3"
SUFFIXES = (".h5", ".hdf5", ".hdf", ".mat")
BEGINS = (b"\x89HDF\r\n\x1a\n", b"MATLAB 7.3")
_UNITS = ("unit", "units")
NEEDS = ("h5py", "hdf5")


def contents(data: bytes) -> dict[str, Any]:
    """Return the groups as mappings; what a reference leads to is in its place."""
    import h5py

    with h5py.File(io.BytesIO(data), "r") as file:
        return {name: _plain(file, file[name]) for name in file if not name.startswith("#")}


def _plain(file: Any, item: Any) -> Any:
    """Return a group or dataset; MATLAB stores arrays transposed, and texts as numbers."""
    import h5py

    matlab = _text(item.attrs.get("MATLAB_class"))
    if "MATLAB_object_decode" in item.attrs:
        return f"a MATLAB object ({matlab}), which only MATLAB reads; save a structure with time"
    if isinstance(item, h5py.Group):
        hard = [name for name in item if isinstance(item.get(name, getlink=True), h5py.HardLink)]
        fields = {name: _plain(file, item[name]) for name in hard}
        unit = _unit(item)
        several = [value for value in fields.values() if isinstance(value, list)]
        if matlab == "struct" and several and len(several) == len(fields):
            each = zip(*several, strict=True)  # an array of structures has one cell per field
            return [dict(zip(fields, values, strict=True)) for values in each]
        return {**fields, "unit": unit} if unit else fields
    if "MATLAB_empty" in item.attrs:
        return "" if matlab == "char" else "an empty array"
    value = np.asarray(item[()])
    if h5py.check_ref_dtype(item.dtype) is h5py.Reference:
        return [_plain(file, file[r]) if r else "nothing" for r in value.T.ravel()]
    if matlab == "char":
        return "".join(map(chr, value.ravel()))
    if value.dtype.names:
        return {name: value[name] for name in value.dtype.names}
    if value.dtype.kind in "SO" and value.size == 1:
        return _text(value.ravel()[0])
    unit = _unit(item)
    return value.T if matlab else {"values": value, "unit": unit} if unit else value


def _unit(item: Any) -> str:
    return next((_text(item.attrs[key]) for key in item.attrs if key.lower() in _UNITS), "")


def _text(found: Any) -> str:
    if isinstance(found, np.ndarray):
        found = found.ravel()[0] if found.size else ""
    return found.decode("utf-8", "replace") if isinstance(found, bytes) else str(found or "")
