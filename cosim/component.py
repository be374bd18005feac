"""The contract of what the master can step, an FMU or a Python function; names and values in it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stickslip.cosim.errors import ParameterError
from stickslip.fmi.description.model import DefaultExperiment, LearnedVariables
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import (
    FLOATS,
    MAX_ELEMENTS,
    SETTERS,
    Scalar,
    Value,
    Variable,
    parse_element,
)
from stickslip.fmi.messages import printable, suggestion

if TYPE_CHECKING:
    from stickslip.cosim.fmu.library import Library


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
        what = f"expected 1 to {MAX_ELEMENTS}; choose other structural parameters"
        raise ParameterError(f"{variable.name} would have {math.prod(dimensions)} elements, {what}")
    return replace(variable, dimensions=dimensions, start=None)


def converted(variable: Variable, value: object, label: str) -> Value:
    """Return ``value``, also as text, as the type of a variable, called ``label`` in messages.

    Arrays take a numpy array or nested list of their dimensions, or the values row by row.
    """
    if not variable.is_settable:
        what = f"it is a {variable.variability} {variable.causality}"
        advice = "parameters, inputs and variables with a start value can"
        raise ParameterError(f"{label} cannot be set: {what}; {advice}")
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
        what = f"expected an array of the dimensions {variable.dimensions}, got {array.shape}"
        raise ParameterError(f"{label}: {what}")
    return list(array.reshape(-1))


def _checked(variable: Variable, value: object, label: str) -> Scalar:
    try:
        result = _converted(variable, value)
    except (TypeError, ValueError, KeyError, OverflowError):
        items = suggestion(str(value), dict(variable.items)) if variable.items else ""
        what = f"expected a value of type {variable.type}, got {printable(repr(value), 80)}{items}"
        raise ParameterError(f"{label}: {what}") from None
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
    is_equal = isinstance(value, str) or result == value
    if _C_TYPES[variable.type](result).value != result or not is_equal:
        raise ValueError
    return result


def integer_range(variable: Variable) -> tuple[int, int]:
    """Return the lowest and highest number that a variable takes; 0 and 1 where it is Boolean."""
    if variable.type == "Boolean":
        return 0, 1
    limits = np.iinfo(_C_TYPES[variable.type])
    return int(limits.min), int(limits.max)


def _check_range(variable: Variable, value: float, label: str) -> None:
    lowest = -math.inf if variable.minimum is None else variable.minimum
    highest = math.inf if variable.maximum is None else variable.maximum
    if not (math.isfinite(value) and lowest <= value <= highest):
        unit = f" {variable.unit}" if variable.unit else ""
        what = f"is outside its range {lowest} to {highest}{unit}"
        raise ParameterError(f"{label} = {value}{unit} {what}")


def _integer(text: str) -> int:
    """Read ``-3`` and ``3.0``, whatever the number of digits of the former."""
    try:
        return int(text)
    except ValueError:
        number = float(text)
        if not number.is_integer():
            raise
        return int(number)


Interface = Literal["co_simulation", "model_exchange"]


class Component:
    """What a system connects and a simulation steps; a kind sets what differs from the defaults.

    Attributes
    ----------
    label : file or function, for messages
    identity : what must be the same for a saved state to fit
    binary : key of its code: components with the same code have the same one
    version : of FMI, whose functions the table has: 2 or 3
    interface : the one it is run by
    variables : name -> Variable, inputs and outputs among them
    aliases : other name -> name
    units : name -> Unit
    feedthrough : output -> the inputs it depends on without delay
    experiment : the times it proposes, s, and the tolerance
    structural : names of structural parameters
    learned : what it learns in a run
    event_mode, has_arrays, needs_tool, once_per_process : see Fmu
    serializes, restores_state, interpolates_inputs, varies_step : its abilities
    """

    label: str
    identity: str
    binary: Path
    token = ""
    version: int = 2
    interface: Interface = "co_simulation"
    variables: Mapping[str, Variable]
    aliases: Mapping[str, str] = {}
    units: Mapping[str, Unit] = {}
    feedthrough: Mapping[str, frozenset[str]]
    experiment = DefaultExperiment()
    structural: Sequence[str] = ()
    learned = LearnedVariables()
    event_mode = has_arrays = needs_tool = once_per_process = False
    serializes = restores_state = interpolates_inputs = varies_step = False

    def table(self) -> Library:
        """Return the functions by which the master steps it, under their names in FMI.

        They are called in this order: ``Instantiate``; in each run ``Reset`` (not in the first one
        of an instance), ``SetupExperiment``, setters of start values, ``EnterInitializationMode``,
        setters of inputs and getters of outputs as often as loops need them, and
        ``ExitInitializationMode``; in each step setters of inputs, ``DoStep``, getters of outputs;
        ``Terminate`` at the end of the run; ``FreeInstance`` once. Where it declares
        ``restores_state``, its state is saved and restored between steps.

        A status beyond a warning ends the run with a ``SimulationError`` that names the component
        and the call; the component is then instantiated again before the next run. After ``fatal``
        nothing more is called on any of its instances. A step that is discarded is tried in parts
        where it declares ``restores_state`` and ``varies_step``.
        """
        raise NotImplementedError

    def restore(self) -> None:
        """Bring changed files of the component back before it is prepared."""

    def find(self, name: str, lengths: Mapping[str, int] | None = None) -> Variable | None:
        """Return a variable by name or alias, or an element of an array: ``name[i,j]``.

        ``lengths`` are the structural parameters that differ from their start values.
        """
        variable = self.variables.get(name) or self.variables.get(self.aliases.get(name, ""))
        if variable is not None:
            variable = resized(variable, lengths) if lengths else variable
            return variable if variable.name == name else replace(variable, name=name)
        if element := parse_element(name):
            array = self.find(element[0], lengths)
            return array.at(element[1]) if array is not None else None
        return None

    def unit(self, variable: Variable) -> Unit | None:
        """Return the unit of one of its variables, None when it has none."""
        if variable.unit is None:
            return None
        unit = self.units.get(variable.unit, Unit(variable.unit))
        return replace(unit, relative=True) if variable.relative else unit


def component_of(name: str) -> str:
    """Return ``component`` of ``component.variable``."""
    return name.partition(".")[0]


def variable_of(name: str) -> str:
    """Return ``variable`` of ``component.variable``; it may hold dots itself."""
    return name.partition(".")[2]


def check_name(name: str) -> str | None:
    """Return why nothing can be called so, as names head columns of tables; None where it can."""
    if not name or "." in name:
        return "it is empty or has a dot"
    if not name.isprintable():
        return "it has control characters"
    if name[0] in "=+-@":
        return f"it begins with {name[0]!r}, which spreadsheets take for a formula"
    return None
