"""One variable of an FMU, and what may be written to it."""

from __future__ import annotations

import math
from ctypes import (
    c_bool,
    c_char_p,
    c_double,
    c_float,
    c_int8,
    c_int16,
    c_int32,
    c_int64,
    c_uint8,
    c_uint16,
    c_uint32,
    c_uint64,
)
from dataclasses import dataclass
from typing import Any

from cosim.errors import ParameterError

Value = float | int | bool | str

# Per FMI version and type: the function that sets it and the C type it takes.
SETTERS: dict[int, dict[str, tuple[str, Any]]] = {
    2: {
        "Real": ("fmi2SetReal", c_double),
        "Integer": ("fmi2SetInteger", c_int32),
        "Enumeration": ("fmi2SetInteger", c_int32),
        "Boolean": ("fmi2SetBoolean", c_int32),
        "String": ("fmi2SetString", c_char_p),
    },
    3: {
        "Float32": ("fmi3SetFloat32", c_float),
        "Float64": ("fmi3SetFloat64", c_double),
        "Int8": ("fmi3SetInt8", c_int8),
        "UInt8": ("fmi3SetUInt8", c_uint8),
        "Int16": ("fmi3SetInt16", c_int16),
        "UInt16": ("fmi3SetUInt16", c_uint16),
        "Int32": ("fmi3SetInt32", c_int32),
        "UInt32": ("fmi3SetUInt32", c_uint32),
        "Int64": ("fmi3SetInt64", c_int64),
        "UInt64": ("fmi3SetUInt64", c_uint64),
        "Enumeration": ("fmi3SetInt64", c_int64),
        "Boolean": ("fmi3SetBoolean", c_bool),
        "String": ("fmi3SetString", c_char_p),
    },
}

_C_TYPES = {name: c_type for setters in SETTERS.values() for name, (_, c_type) in setters.items()}
_WORDS = {"true": True, "1": True, "false": False, "0": False}


@dataclass(frozen=True)
class Variable:
    """A variable as the FMU describes it.

    Attributes
    ----------
    type : Real, Integer, ... of FMI 2.0 or Float64, Int32, ... of FMI 3.0
    unit : as the FMU writes it; None when it gives none
    start, minimum, maximum, nominal : in ``unit``; None when the FMU gives none
    dimensions : length of each; empty for a scalar
    """

    name: str
    reference: int
    type: str
    causality: str
    variability: str
    initial: str | None = None
    unit: str | None = None
    start: Value | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    description: str = ""
    dimensions: tuple[int, ...] = ()

    @classmethod
    def from_fmpy(cls, variable: Any) -> Variable:
        """Take a variable from FMPy's model description."""

        def number(attribute: str) -> float | None:
            text = getattr(variable, attribute)
            if text is None:
                text = getattr(variable.declaredType, attribute, None)
            return None if text is None else float(text)

        return cls(
            name=variable.name,
            reference=int(variable.valueReference),
            type=variable.type,
            causality=variable.causality or "local",
            variability=variable.variability or "continuous",
            initial=variable.initial,
            unit=variable.unit or getattr(variable.declaredType, "unit", None),
            start=_start(variable),
            minimum=number("min"),
            maximum=number("max"),
            nominal=number("nominal"),
            description=variable.description or "",
            dimensions=tuple(variable.shape or ()),
        )

    @property
    def is_signal(self) -> bool:
        """Whether it can be connected and recorded: a scalar of 64-bit floating point."""
        return self.type in {"Real", "Float64"} and not self.dimensions

    def checked(self, value: object, label: str) -> Value:
        """Return ``value`` as this variable's type; text is read as a number where one is due.

        ``label`` names the variable in messages.

        Raises
        ------
        ParameterError
            When the variable cannot be set, or not to this value.
        """
        has_start = self.causality in {"parameter", "input"} or self.initial in {"exact", "approx"}
        if not has_start or self.variability == "constant":
            raise ParameterError(
                f"{label} cannot be set: it is a {self.variability} {self.causality};"
                " parameters, inputs and variables with a start value can"
            )
        if self.dimensions or self.type in {"Binary", "Clock"}:
            kind = "an array" if self.dimensions else self.type
            raise ParameterError(f"{label} cannot be set: it is {kind}, which is not supported")
        try:
            result = self._converted(value)
        except (TypeError, ValueError, KeyError, OverflowError):
            raise ParameterError(
                f"{label}: expected a value of type {self.type}, got {value!r}"
            ) from None
        if isinstance(result, (int, float)):
            self._check_range(result, label)
        return result

    def _converted(self, value: Any) -> Value:
        if self.type == "String":
            if not isinstance(value, str):
                raise TypeError
            return value
        if self.type == "Boolean":
            return _WORDS[str(value).lower()]
        if self.type in {"Real", "Float64", "Float32"}:
            return float(value)
        result = int(value)
        if result != float(value) or _C_TYPES[self.type](result).value != result:
            raise ValueError
        return result

    def _check_range(self, value: float, label: str) -> None:
        lowest = -math.inf if self.minimum is None else self.minimum
        highest = math.inf if self.maximum is None else self.maximum
        if not (math.isfinite(value) and lowest <= value <= highest):
            unit = f" {self.unit}" if self.unit else ""
            raise ParameterError(
                f"{label} = {value}{unit} is outside its range {lowest} .. {highest}{unit}"
            )


def _start(variable: Any) -> Value | None:
    text = variable.start
    if text is None or variable.shape or variable.type in {"Binary", "Clock"}:
        return None
    if variable.type == "String":
        return str(text)
    if variable.type == "Boolean":
        return _WORDS[text]
    return float(text) if variable.type in {"Real", "Float64", "Float32"} else int(text)
