"""The reader of MAT files, run as a process of its own: scipy crashes on some damaged files.

It reads the file from standard input and writes an .npz file to standard output: ``names``, and
one array per name in their order. What holds no real numbers is a text that says what it holds.
"""

from __future__ import annotations

import io
import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

MEMORY = 1 << 32
"""Bytes of address space, so that a small compressed file cannot fill the memory."""


def arrays(prefix: str, found: Any) -> Iterator[tuple[str, Any]]:
    """Yield name and array of a variable; of a struct, those of its fields."""
    kind = found.dtype.kind if isinstance(found, np.ndarray) else ""
    if kind == "V" and found.size == 1:
        for name, value in zip(found.dtype.names, found.item(), strict=True):
            yield from arrays(f"{prefix}.{name}", value)
    elif kind and kind in "biuf":
        yield prefix, found
    else:
        kinds = {"c": "complex numbers", "U": "text", "V": "an array of structs", "O": "objects"}
        yield prefix, np.array(kinds.get(kind, type(found).__name__))


def version_7_3(data: bytes) -> Iterator[tuple[str, Any]]:
    """Yield name and array of the datasets of an HDF5 file."""
    import h5py

    found: dict[str, Any] = {}
    with h5py.File(io.BytesIO(data), "r") as file:
        file.visititems(lambda name, item: found.update({name: item}))
        for name, item in found.items():
            if isinstance(item, h5py.Dataset) and not name.startswith("#"):
                empty = "MATLAB_empty" in item.attrs
                value = np.array("an empty array") if empty else np.asarray(item[()])
                yield from arrays(name.replace("/", "."), value)


def main() -> None:
    """Read, and write what was found."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    data = sys.stdin.buffer.read()
    if data.startswith((b"MATLAB 7.3", b"\x89HDF")):
        found = dict(version_7_3(data))
    else:
        from scipy.io import loadmat

        variables = loadmat(io.BytesIO(data)).items()  # type: ignore[arg-type]
        found = {
            name: value
            for variable, whole in variables
            if not variable.startswith("__")
            for name, value in arrays(variable, whole)
        }
    np.savez(sys.stdout.buffer, *found.values(), names=np.array([*found], dtype=str))


if __name__ == "__main__":
    main()
