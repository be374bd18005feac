"""The binary of an FMU, loaded, with its functions in the kernel's order."""

from __future__ import annotations

import ctypes
import os
import re
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any, Protocol

from stickslip.cosim import kernel
from stickslip.cosim.errors import FmuError
from stickslip.cosim.kernel import plain_arithmetic
from stickslip.cosim.kernel.structures import step_calls
from stickslip.fmi import toolchain
from stickslip.fmi.binary import NotALibrary, read_library
from stickslip.fmi.description import Description
from stickslip.fmi.description.variables import SETTERS
from stickslip.fmi.files import atomic_write
from stickslip.fmi.standard import standard_files

_WRAPPER = Path(__file__).with_name("fmi1.c")

# On Windows, also look beside the binary for the libraries it brings along:
# LOAD_LIBRARY_SEARCH_DEFAULT_DIRS | LOAD_LIBRARY_SEARCH_DLL_LOAD_DIR.
_LOAD_WITH_NEIGHBOURS = 0x1100


class Loadable(Protocol):
    """What is read of an FMU to load its binary."""

    path: Path
    folder: Path
    binary: Path
    version: int
    identifier: str
    description: Description

    @property
    def interface(self) -> str:
        """By which it is run."""


class Library:
    """Addresses of an FMU's functions.

    Attributes
    ----------
    fault : what a Python function in place of a binary raised last
    calls : addresses in the order of the kernel's table; none for Model Exchange
    lacks_reset : the name of the function, where the binary does not have it
    resources : where the FMU finds its resources: a URI in FMI 2.0, a path in FMI 3.0
    """

    fault: BaseException | None = None

    def __init__(self, fmu: Loadable) -> None:
        self._fmu, self._version = fmu, fmu.version
        kernel.note_call(fmu.path.name, "loading its binary")
        self._library: Any = _load(str(fmu.binary))
        folder = fmu.folder / "resources"
        if fmu.description.standard == 1:
            self._library = self._upgraded()
            folder = fmu.folder
        self.calls: list[int] = []
        self.lacks_reset = self._missing_reset()
        self.resources = folder.as_uri() if fmu.version == 2 else f"{folder}{os.sep}"
        if fmu.interface == "co_simulation":
            self.calls = self._step_calls()

    def accessor(self, type_name: str, verb: str) -> tuple[str, int, Any]:
        """Return name, address and C type of what does the verb, Set or Get, with a type."""
        setter, c_type = SETTERS[self._version][type_name]
        name = setter.replace("Set", verb)
        return name, self.address(name), c_type

    def state_calls(self) -> tuple[int, int, int]:
        """Return the addresses of the functions that save, restore and free a state."""
        word = "fmi2{}FMUstate" if self._version == 2 else "fmi3{}FMUState"
        save, restore, free = (self.address(word.format(s)) for s in ("Get", "Set", "Free"))
        return save, restore, free

    def function(self, name: str) -> Any:
        """Return a function for use from Python; it returns an FMI status."""
        self.address(name)
        return self._library[name]

    def address(self, name: str) -> int:
        """Return the address of a function."""
        try:
            function = getattr(self._library, name)
        except AttributeError:
            raise self._lacks(name) from None
        return ctypes.cast(function, ctypes.c_void_p).value or 0

    def _upgraded(self) -> ctypes.CDLL:
        """Return the functions of FMI 1.0 under the names of FMI 2.0."""
        library, names = _fmi1(self._fmu.folder.name)
        places = (ctypes.c_void_p * len(names)).in_dll(library, "calls")
        need = "M" if self._fmu.interface == "model_exchange" else "C"
        places[:] = [
            self.address(f"{self._fmu.identifier}_fmi{name}") if need in needed_for else 0
            for name, needed_for in names
        ]
        return library

    def _missing_reset(self) -> str:
        name = f"fmi{self._version}Reset"
        if self._fmu.description.standard == 1 and self._fmu.interface == "model_exchange":
            return name
        try:
            self.address(name)
        except FmuError:
            return name
        return ""

    def _step_calls(self) -> list[int]:
        """Return what the kernel needs; without a reset an FMU can be run, too."""
        names = step_calls(self._version)
        return [0 if name == self.lacks_reset else self.address(name) for name in names]

    def _lacks(self, name: str) -> FmuError:
        what = f"has no function {name}, which the standard requires"
        return FmuError(f"{self._fmu.path}: {self._fmu.binary.name} {what}")


class UnloadedLibrary(Library):
    """The functions of a binary that is only read; none has an address."""

    def __init__(self, fmu: Loadable) -> None:
        self._fmu, self._version = fmu, fmu.version
        self.resources = ""
        try:
            self._names = read_library(fmu.binary.read_bytes()).exports
        except (NotALibrary, OSError) as fault:
            raise FmuError(f"{fmu.binary}: {fault}") from fault
        self.lacks_reset = self._missing_reset()
        self.calls = self._step_calls() if fmu.interface == "co_simulation" else []

    def address(self, name: str) -> int:
        """Return 0 for a function that is there, see Library."""
        if name not in self._names:
            raise self._lacks(name)
        return 0


def prepare_library(fmu: Loadable) -> list[Path]:
    """Compile what a process that must not compile needs for an FMU; return where that lies."""
    if fmu.description.standard != 1:
        return []
    _fmi1(fmu.folder.name)
    return [fmi1_wrapper()]


def fmi1_wrapper(platform: toolchain.Platform | None = None) -> Path:
    """Return the library of ``fmi1.c``, for this machine by default."""
    source = _WRAPPER.read_text(encoding="utf-8")
    files = {f"system/{h.name}": h.read_text() for h in standard_files("c-code").glob("fmi[12]*.h")}
    return toolchain.shared_library("fmi1", {"fmi1.c": source, **files}, platform=platform)


@cache
def _fmi1(fmu: str) -> tuple[ctypes.CDLL, list[tuple[str, str]]]:
    """Return a library of its own for an FMU of FMI 1.0, and what it calls, by which interface."""
    library = fmi1_wrapper()
    own = library.with_name(f"fmi1_{fmu}{library.suffix}")
    if not own.exists():
        atomic_write(own, library.read_bytes())
    calls = re.findall(r'X\((\w+), "(\w+)"\)', _WRAPPER.read_text(encoding="utf-8"))
    return ctypes.CDLL(str(own)), calls


@cache
@plain_arithmetic()
def _load(binary: str) -> ctypes.CDLL:
    try:
        return ctypes.CDLL(binary, winmode=_LOAD_WITH_NEIGHBOURS)
    except OSError as fault:
        if _load_neighbours(Path(binary)):
            with suppress(OSError):
                return ctypes.CDLL(binary, winmode=_LOAD_WITH_NEIGHBOURS)
        raise FmuError(f"{binary}: cannot be loaded: {fault}{_advice(str(fault))}") from fault


def _advice(fault: str) -> str:
    """Return what to do where the loader of Linux misses a library, or a version of one."""
    if re.search(r"version `\w+' not found", fault):
        return "; the FMU was built on a newer system: use one, or export it again on this one"
    missing = re.match(r"(\S+?)\.so(?:\.(\d+))?[\d.]*: cannot open shared object file", fault)
    if missing is None:
        return ""
    name, number = missing.groups()
    if not number:
        return "; export the FMU again with this library inside, or install the tool that made it"
    package = name if name.startswith("libpython") else f"{name}{number}"
    return (
        f"; install this library (the package {package} in Debian and Ubuntu, in an older release"
        " where yours has none), or export the FMU again on this system"
    )


def _load_neighbours(binary: Path) -> int:
    """Load the libraries beside a binary, which may need each other; return how many."""
    waiting = [p for p in binary.parent.glob(f"*{binary.suffix}*") if p != binary]
    n = len(waiting)
    for _ in range(n):
        failed = []
        for path in waiting:
            try:
                ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL, winmode=_LOAD_WITH_NEIGHBOURS)
            except OSError:
                failed.append(path)
        if len(failed) in (0, len(waiting)):
            break
        waiting = failed
    return n - len(failed) if n else 0
