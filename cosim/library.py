"""The binary of an FMU, loaded, with its functions in the kernel's order."""

from __future__ import annotations

import ctypes
import os
from functools import cache
from typing import Any

from cosim import kernel
from cosim.errors import FmuError
from cosim.fmu import Fmu
from cosim.variables import SETTERS

# On Windows, also look beside the binary for the libraries it brings along:
# LOAD_LIBRARY_SEARCH_DEFAULT_DIRS | LOAD_LIBRARY_SEARCH_DLL_LOAD_DIR.
_LOAD_WITH_NEIGHBOURS = 0x1100


class Library:
    """Addresses of an FMU's functions.

    Attributes
    ----------
    calls : addresses in the order of the kernel's table
    resources : where the FMU finds its resources: a URI in FMI 2.0, a path in FMI 3.0

    Raises
    ------
    FmuError
        When the binary cannot be loaded or lacks a function.
    """

    def __init__(self, fmu: Fmu) -> None:
        self._fmu = fmu
        self._library = _load(str(fmu.binary))
        folder = fmu.folder / "resources"
        self.resources = folder.as_uri() if fmu.version == 2 else f"{folder}{os.sep}"
        self.calls = [self._address(name) for name in kernel.calls(fmu.version)]

    def setter(self, type_name: str) -> tuple[str, int, Any]:
        """Return name, address and C type of the function that sets variables of a type."""
        name, c_type = SETTERS[self._fmu.version][type_name]
        return name, self._address(name), c_type

    def function(self, name: str) -> Any:
        """Return a function for use from Python; it returns an FMI status."""
        self._address(name)
        return self._library[name]

    def _address(self, name: str) -> int:
        try:
            function = getattr(self._library, name)
        except AttributeError:
            raise FmuError(
                f"{self._fmu.path}: {self._fmu.binary.name} has no function {name},"
                " which the standard requires"
            ) from None
        return ctypes.cast(function, ctypes.c_void_p).value or 0


@cache
def _load(binary: str) -> ctypes.CDLL:
    try:
        return ctypes.CDLL(binary, winmode=_LOAD_WITH_NEIGHBOURS)
    except OSError as fault:
        raise FmuError(f"{binary}: cannot be loaded: {fault}") from fault
