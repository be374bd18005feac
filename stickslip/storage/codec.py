"""Results as plain data: dataclasses whose fields state their units.

    @dataclass(frozen=True)
    class Hold:
        swing: float = field(metadata=entry("m"))
        reversals: int

    encode(Hold(1e-6, 3)) == {"swing": {"value": 1e-6, "unit": "m"}, "reversals": 3}

A number that is not finite is None.
"""

from collections.abc import Callable, Mapping
from dataclasses import Field, fields, is_dataclass
from typing import Any

from stickslip.output import plain

Unit = str | Mapping[str, str] | Callable[[str], str]
"""A unit, or the units of values by their names."""


def entry(unit: Unit = "", key: str = "", *, stored: bool = True) -> dict[str, Any]:
    """Return the metadata of a field: unit, its name in files if another, whether it is stored."""
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


def _stored(kind: Any) -> list[Field[Any]]:
    return [one for one in fields(kind) if one.metadata.get("stored", True)]


def _key(one: Field[Any]) -> str:
    return one.metadata.get("key") or one.name
