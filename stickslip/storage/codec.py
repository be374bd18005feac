"""Results as plain data and back: dataclasses whose fields state their units.

    @dataclass(frozen=True)
    class Hold:
        swing: float = field(metadata=entry("m"))
        reversals: int

    encode(Hold(1e-6, 3)) == {"swing": {"value": 1e-6, "unit": "m"}, "reversals": 3}
    decode(Hold, encode(Hold(1e-6, 3))) == Hold(1e-6, 3)

A number that is not finite is None.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any, TypeVar, cast, get_args, get_origin, get_type_hints

import numpy as np

from stickslip.output import plain

T = TypeVar("T")
Unit = str | Mapping[str, str] | Callable[[str], str]
"""A unit, or the units of values by their names."""


def entry(unit: Unit = "", key: str = "", *, stored: bool = True) -> dict[str, Any]:
    """Return the metadata of a field: unit and name in files, and whether they have it.

    The name is by default that of the field.
    """
    return {"unit": unit, "key": key, "stored": stored}


def units(kind: Any) -> dict[str, str]:
    """Return the units of the fields of a dataclass that state one, by their names in files."""
    known = {_key(one): one.metadata.get("unit") for one in _stored(kind)}
    return {name: unit for name, unit in known.items() if unit and isinstance(unit, str)}


def encode(value: Any, of_drive: Callable[[str], str] = str) -> Any:
    """Return a value as plain data; ``of_drive`` turns units of a linear drive to those at hand."""
    if isinstance(value, Mapping):
        return {str(name): encode(one, of_drive) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [encode(one, of_drive) for one in value]
    if not is_dataclass(value):
        return plain(value)
    found = {}
    for one in _stored(type(value)):
        own, unit = getattr(value, one.name), one.metadata.get("unit")
        found[_key(one)] = state(own, unit, of_drive) if unit else encode(own, of_drive)
    return found


def state(value: Any, unit: Unit, of_drive: Callable[[str], str] = str) -> dict[str, Any]:
    """Return a value with its unit as plain data: a number, an estimate, or several by name."""
    if isinstance(value, Mapping):

        def unit_of(name: str) -> str:
            if isinstance(unit, str):
                return unit
            return unit[name] if isinstance(unit, Mapping) else unit(name)

        return {name: state(one, unit_of(name), of_drive) for name, one in value.items()}
    number = float(value) if isinstance(value, int) else plain(value)
    stated = encode(value) if is_dataclass(value) else {"value": number}
    return {**stated, "unit": of_drive(str(unit))}


def decode(kind: type[T], data: Any) -> T:
    """Return what ``encode`` has written.

    Raises ValueError when the data are not of this kind; names the entry.
    """
    return cast(T, _decoded(kind, data, kind.__name__))


def _stored(kind: Any) -> list[Field[Any]]:
    return [one for one in fields(kind) if one.metadata.get("stored", True)]


def _key(one: Field[Any]) -> str:
    return one.metadata.get("key") or one.name


def _decoded(kind: Any, data: Any, where: str) -> Any:
    origin, arguments = get_origin(kind) or kind, get_args(kind)
    if type(None) in arguments:
        return None if data is None else _decoded(arguments[0], data, where)
    if is_dataclass(origin):
        return _record(origin, data, where)
    if origin is np.ndarray:
        return np.array([_decoded(float, one, where) for one in data])
    if isinstance(origin, type) and issubclass(origin, Mapping) and isinstance(data, Mapping):
        return {name: _decoded(arguments[1], one, f"{where}.{name}") for name, one in data.items()}
    if origin is float and (data is None or type(data) in (int, float)):
        return math.nan if data is None else float(data)
    if origin in (int, str, bool) and type(data) is origin:
        return data
    if origin in (list, tuple) and isinstance(data, list):
        return origin(_decoded(arguments[0], one, where) for one in data)
    raise ValueError(f"{where}: expected {getattr(kind, '__name__', kind)}, got {data!r:.80}")


def _record(kind: Any, data: Any, where: str) -> Any:
    if not isinstance(data, Mapping):
        raise ValueError(f"{where}: expected names, got {data!r:.80}")  # noqa: TRY004
    hints, stated, values = get_type_hints(kind), units(kind), {}
    for one in _stored(kind):
        key = _key(one)
        if key not in data and one.default is MISSING:
            raise ValueError(f"{where}: '{key}' is missing")
        if key in data:
            value, unit = data[key], stated.get(key)
            if unit is not None:
                if not isinstance(value, Mapping) or value.get("unit") != unit:
                    raise ValueError(
                        f"{where}.{key}: expected a value in {unit}, got {value!r:.80}"
                    )
                value = value["value"]
            values[one.name] = _decoded(hints[one.name], value, f"{where}.{key}")
    return kind(**values)
