"""The process in which a library reads a log: some end their process on damaged files.

It takes the path of a module of ``formats/``, reads the file from standard input and writes an .npz
file to standard output: arrays, and ``signals``, JSON with the name, the unit and the array of each
signal and of its times. What holds no real numbers is a text that says what it holds.
"""

import json
import sys
from collections.abc import Iterator, Mapping
from importlib.util import module_from_spec, spec_from_file_location
from typing import Any

import numpy as np

MEMORY = 1 << 32  # bytes of address space, so that a small compressed file cannot fill the memory
_VALUES = ("values", "data", "value")
_LABELS = ("label", "name")
_UNITS = ("unit", "units")
_FURTHER = {*_LABELS, *_UNITS, "time", "dimensions"}
"""Fields that, beside values, make a structure one signal: those of Simulink and dSPACE."""
_TIMES = {"ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0}
_KINDS = {"c": "complex numbers", "U": "text", "S": "text", "V": "an array of structs"}

_Signal = tuple[str, Any, str, Any]  # name, values or what they are instead, unit, times or None


def signals(prefix: str, found: Any, time: Any = None) -> Iterator[_Signal]:
    """Yield the signals of a tree of mappings, lists and arrays."""
    if isinstance(found, Mapping):
        fields = {key.lower(): value for key, value in found.items()}
        own = _seconds(fields.get("time"))
        values = next((fields[key] for key in _VALUES if key in fields), None)
        if values is not None and _FURTHER & fields.keys():
            name = _text(fields, _LABELS) or prefix
            if isinstance(values, Mapping):
                yield from signals(name, values, time if own is None else own)
            else:
                yield name, _leaf(values), _text(fields, _UNITS), time if own is None else own
            return
        whole = own is not None and "signals" in fields  # a structure with time of Simulink
        for key, value in found.items():
            if whole and key == "signals":
                yield from signals(prefix, value, own)
            elif not (whole and key.lower() in ("time", "blockname")):
                yield from signals(f"{prefix}.{key}" if prefix else key, value, time)
    elif isinstance(found, list):
        for k, value in enumerate(found, start=1):
            yield from signals(prefix if len(found) == 1 else f"{prefix}({k})", value, time)
    else:
        yield prefix, _leaf(found), "", time


def _text(fields: Mapping[str, Any], keys: tuple[str, ...]) -> str:
    return next((v.strip() for key in keys if isinstance(v := fields.get(key), str)), "")


def _is_numbers(found: Any) -> bool:
    return isinstance(found, np.ndarray) and found.dtype.kind in "biufmM"


def _seconds(found: Any) -> Any:
    """Return numbers as seconds, None for anything else."""
    if isinstance(found, Mapping) and _is_numbers(found.get("values")):
        return found["values"] * _TIMES.get(found.get("unit", "s"), 1.0)
    return found if _is_numbers(found) else None


def _leaf(found: Any) -> Any:
    """Return numbers as they are, points in time as seconds, else a text."""
    if isinstance(found, np.ndarray) and found.dtype.kind in "mM":
        since: Any = found.ravel() - (found.ravel()[:1] if found.dtype.kind == "M" else 0)
        return since / np.timedelta64(1, "s")
    if _is_numbers(found) or isinstance(found, str):
        return found
    kind = found.dtype.kind if isinstance(found, np.ndarray) else type(found).__name__
    return _KINDS.get(kind, "objects")


def main() -> None:
    """Read, and write what was found."""
    if sys.platform != "win32":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    specification = spec_from_file_location("log_format", sys.argv[1])
    assert specification is not None  # noqa: S101
    assert specification.loader is not None  # noqa: S101
    module = module_from_spec(specification)
    specification.loader.exec_module(module)
    content = module.contents(sys.stdin.buffer.read())
    arrays: list[Any] = []
    places: dict[int, int] = {}

    def place(array: Any) -> int:
        if id(array) not in places:
            places[id(array)] = len(arrays)
            arrays.append(array)
        return places[id(array)]

    if isinstance(content, str):
        arrays.append(np.frombuffer(content.encode(), dtype=np.uint8))
        found = None
    else:
        found = [
            (
                name,
                unit,
                *((None, value) if isinstance(value, str) else (place(value), "")),
                None if time is None else place(_leaf(time)),
            )
            for name, value, unit, time in signals("", content)
        ]
    np.savez(sys.stdout.buffer, *arrays, signals=np.array(json.dumps(found)))


if __name__ == "__main__":
    main()
