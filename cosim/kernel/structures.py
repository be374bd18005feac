"""The structures of the kernel's headers as ctypes classes of the same name, read from there."""

from __future__ import annotations

import ctypes
import math
import re
from collections.abc import Mapping
from ctypes import POINTER, Structure
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

_HEADERS = ("kernel", "general_path", "coupling", "cvode", "arithmetic", "mark")
_TEXT = re.sub(
    r"/\*.*?\*/",
    "",
    "".join(Path(__file__).with_name(f"{h}.h").read_text(encoding="utf-8") for h in _HEADERS),
    flags=re.DOTALL,
)
_STRUCTURES = re.findall(r"typedef struct[\w ]*\{([^{}]*)\} (\w+);", _TEXT)
_BODIES = {name: body for body, name in _STRUCTURES}


def calls(table: str) -> list[list[str]]:
    """Return the entries of a list such as ``FMI2_CALLS(X)`` in the headers."""
    block = re.search(rf"#define {table}\(X\)((?:.*\\\n)+.*)", _TEXT)
    entries = re.findall(r"X\(([^()]*)", block[1]) if block else []
    return [[word.strip(' "') for word in entry.split(",")] for entry in entries]


def step_calls(version: int) -> list[str]:
    """Return the names of the functions in ``Component.call``."""
    return [f"fmi{version}{name}" for (name,) in calls(f"FMI{version}_CALLS")]


MAX_PAST = 3
_INTEGERS = [f"{sign}int{bits}" for bits in (8, 16, 32, 64) for sign in ("", "u")]
STORED: dict[str, Any] = {"double": ctypes.c_double, "float": ctypes.c_float}
STORED |= {f"{name}_t": getattr(ctypes, f"c_{name}") for name in _INTEGERS}
STORED |= {"bool": ctypes.c_bool, "char *": ctypes.c_char_p}
"""The types of values in the order of ``enum Stored``; the last stands for all text."""
_LENGTHS = {"N_CALLS": len(calls("GENERAL_CALLS")), "MAX_PAST": MAX_PAST}
_TYPES: dict[str, Any] = {
    **STORED,
    "char": ctypes.c_char,
    "size_t": ctypes.c_size_t,
    "fmi3Boolean": ctypes.c_bool,
    "fmi3Float64": ctypes.c_double,
    "fmi2CallbackFunctions": ctypes.c_void_p * 5,
    "Setter": ctypes.c_void_p,
    "Calls": ctypes.c_void_p * len(calls("FMI2_CALLS")),
}


def __getattr__(name: str) -> Any:
    if name not in _BODIES:
        raise AttributeError(name)
    _TYPES[name] = globals()[name] = type(name, (Structure,), {"_fields_": _fields(name)})
    return _TYPES[name]


def _type(name: str) -> Any:
    return _TYPES.get(name) or (__getattr__(name) if name in _BODIES else None)


def _fields(name: str) -> list[tuple[str, Any]]:
    fields = []
    for base, declared in re.findall(r"(?:const |struct )*(\w+)\b ?([^;]+);", _BODIES[name]):
        for stars, field, length in re.findall(r"(\**)(\w+)(?:\[(\w+)\])?", declared):
            kind: Any = _type(f"{base} {stars}" if base == "char" and stars else base)
            if stars and base != "char":
                kind = POINTER(kind) if kind else ctypes.c_void_p
            if length:
                kind = kind * (_LENGTHS.get(length) or int(length))
            fields.append((field, kind))
    return fields


def doubles(values: NDArray[np.float64]) -> Any:
    """Return a pointer to an array, which the caller must keep."""
    return values.ctypes.data_as(POINTER(ctypes.c_double))


def put_back(places: Mapping[str, NDArray[Any]], memory: Mapping[str, NDArray[Any]]) -> None:
    """Write what was kept of places back into them; ValueError where a shape is another."""
    for name, place in places.items():
        if memory[name].shape != place.shape:
            raise ValueError(f"{memory[name].shape} {name}, expected {place.shape}")
        place[:] = memory[name]


class Mark(Structure):
    """The last call that was begun, and the name of the component in a call from Python."""

    _fields_ = (*_fields("Mark"), ("name", ctypes.c_char * 512))

    def begin(self, name: str, call: str) -> None:
        """Note a call that the kernel does not make: on whom, and which."""
        self.component = None
        self.t = math.nan
        self.name, self.call = name.encode()[:511], call.encode()[:63]
