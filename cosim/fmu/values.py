"""Values that are written to the variables of an FMU: checked and converted to their types."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from stickslip.cosim.errors import ParameterError
from stickslip.fmi.description.variables import (
    FLOATS,
    MAX_ELEMENTS,
    SETTERS,
    Scalar,
    Value,
    Variable,
)
from stickslip.fmi.messages import printable, suggestion

_C_TYPES = {name: c_type for setters in SETTERS.values() for name, (_, c_type) in setters.items()}
_WORDS = {"true": True, "1": True, "on": True, "false": False, "0": False, "off": False}


def resized(variable: Variable, lengths: Mapping[str, int]) -> Variable:
    """Return a variable with the dimensions that these structural parameters give it."""
    dimensions = tuple(
        lengths.get(name or "", length)
        for length, name in zip(variable.dimensions, variable.structure, strict=True)
    )
    if dimensions == variable.dimensions:
        return variable
    if not 0 < math.prod(dimensions) <= MAX_ELEMENTS:
        raise ParameterError(
            f"{variable.name} would have {math.prod(dimensions)} elements, expected 1 to"
            f" {MAX_ELEMENTS}; choose other structural parameters"
        )
    return replace(variable, dimensions=dimensions, start=None)


def converted(variable: Variable, value: object, label: str) -> Value:
    """Return ``value``, also as text, as the type of a variable, called ``label`` in messages.

    Arrays take a numpy array or nested list of their dimensions, or the values row by row.
    """
    if not variable.is_settable:
        raise ParameterError(
            f"{label} cannot be set: it is a {variable.variability} {variable.causality};"
            " parameters, inputs and variables with a start value can"
        )
    if variable.type == "Clock":
        raise ParameterError(f"{label} cannot be set: it is a clock, which ticks by itself")
    if variable.dimensions:
        return tuple(_checked(variable, item, label) for item in _items(variable, value, label))
    return _checked(variable, value, label)


def _items(variable: Variable, value: Any, label: str) -> list[Any]:
    items = value.split() if isinstance(value, str) else value
    try:
        array = np.asarray(items, dtype=None if variable.type in FLOATS else object)
    except ValueError:
        array = np.empty(0)
    if array.shape not in {variable.dimensions, (variable.size,)}:
        raise ParameterError(
            f"{label}: expected an array of the dimensions {variable.dimensions}, got {array.shape}"
        )
    return list(array.reshape(-1))


def _checked(variable: Variable, value: object, label: str) -> Scalar:
    try:
        result = _converted(variable, value)
    except (TypeError, ValueError, KeyError, OverflowError):
        items = suggestion(str(value), dict(variable.items)) if variable.items else ""
        raise ParameterError(
            f"{label}: expected a value of type {variable.type}, got"
            f" {printable(repr(value), 80)}{items}"
        ) from None
    if isinstance(result, (int, float)):
        _check_range(variable, result, label)
    return result


def _converted(variable: Variable, value: Any) -> Scalar:
    if isinstance(value, str) and value in (items := dict(variable.items)):
        return items[value]
    if variable.type not in ("String", "Binary") and "_" in str(value):
        raise ValueError  # 1_000 is a number to Python alone
    if variable.type in FLOATS:
        return float(value)
    if variable.type == "String":
        if not isinstance(value, str):
            raise TypeError
        return value
    if variable.type == "Binary":
        return bytes.fromhex(value) if isinstance(value, str) else bytes(memoryview(value))
    if variable.type == "Boolean":
        return _WORDS[str(value).lower()]
    result = _integer(value) if isinstance(value, str) else int(value)
    if _C_TYPES[variable.type](result).value != result or (
        not isinstance(value, str) and result != value
    ):
        raise ValueError
    return result


def integer_range(variable: Variable) -> tuple[int, int]:
    """Return the lowest and highest number that a variable takes; 0 and 1 where it is Boolean."""
    if variable.type == "Boolean":
        return 0, 1
    c_type = _C_TYPES[variable.type]
    bits = 8 * ctypes.sizeof(c_type) - (c_type(-1).value < 0)
    return (-(2**bits) if c_type(-1).value < 0 else 0), 2**bits - 1


def _check_range(variable: Variable, value: float, label: str) -> None:
    lowest = -math.inf if variable.minimum is None else variable.minimum
    highest = math.inf if variable.maximum is None else variable.maximum
    if not (math.isfinite(value) and lowest <= value <= highest):
        unit = f" {variable.unit}" if variable.unit else ""
        raise ParameterError(
            f"{label} = {value}{unit} is outside its range {lowest} to {highest}{unit}"
        )


def _integer(text: str) -> int:
    """Read ``-3`` and ``3.0``, whatever the number of digits of the former."""
    try:
        return int(text)
    except ValueError:
        number = float(text)
        if not number.is_integer():
            raise
        return int(number)
