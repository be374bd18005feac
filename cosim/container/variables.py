"""What a container shows of its system: inputs, outputs and parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Literal

from stickslip.cosim.errors import ConnectionFault, ParameterError
from stickslip.cosim.system.system import System
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Value, Variable
from stickslip.fmi.messages import suggestion

Role = Literal["TIME", "INPUT", "OUTPUT", "PARAMETER", "TUNABLE"]

# FMI 2.0 has one integer for both of these; the 64-bit enumerations of FMI 3.0 are left out.
TYPES = {
    "Real": "REAL",
    "Float64": "REAL",
    "Integer": "INTEGER",
    "Int32": "INTEGER",
    "Boolean": "BOOLEAN",
}


@dataclass(frozen=True)
class Shown:
    """A variable of a container. Its place in the list is its value reference.

    Attributes
    ----------
    source : ``component.variable`` or exposed input that it stands for; empty for time
    """

    name: str
    role: Role
    type: str
    source: str = ""
    unit: Unit | None = None
    start: Value | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    description: str = ""


def shown_variables(
    system: System, outputs: Sequence[str] | None, parameters: Sequence[str] | None
) -> list[Shown]:
    """Return what a container of ``system`` shows, time first.

    Parameters
    ----------
    outputs : names or patterns of ``component.variable`` outputs. By default the outputs of the
        system, or all outputs of its components where it has none
    parameters : names or patterns of ``component.variable`` parameters; all by default

    Raises
    ------
    ConnectionFault, ParameterError
        When a name or pattern matches nothing that can be exposed.
    """
    second = Unit("s", (0, 0, 1, 0, 0, 0, 0, 0))
    time = Shown("time", "TIME", "REAL", unit=second, description="Simulation time")
    inputs = [_input(system, name) for name in system.inputs]
    return [time, *inputs, *_outputs(system, outputs), *_parameters(system, parameters)]


def _input(system: System, name: str) -> Shown:
    target = system.inputs[name][0]
    variable = system.variable(target)
    start = system.parameters.get(target, variable.start)
    return Shown(
        name,
        "INPUT",
        TYPES[variable.type],
        name,
        system.unit_of(name),
        0.0 if start is None else start,
        description=variable.description,
    )


def _outputs(system: System, patterns: Sequence[str] | None) -> list[Shown]:
    every = _signals(system)
    names = dict(system.outputs) if patterns is None else {}
    if not names:
        chosen = list(every) if patterns is None else _matching(every, patterns, ConnectionFault)
        names = {name: name for name in chosen}
    return [
        Shown(
            name,
            "OUTPUT",
            "REAL",
            source,
            system.unit_of(source),
            None,
            every[source].minimum,
            every[source].maximum,
            every[source].nominal,
            every[source].description,
        )
        for name, source in names.items()
    ]


def _signals(system: System) -> dict[str, Variable]:
    return {
        f"{component}.{variable.name}": variable
        for component, fmu in system.components.items()
        for variable in fmu.variables.values()
        if variable.causality == "output" and variable.is_plain
    }


def _parameters(system: System, patterns: Sequence[str] | None) -> list[Shown]:
    every = {
        f"{component}.{variable.name}": variable
        for component, fmu in system.components.items()
        for variable in fmu.variables.values()
        if variable.causality == "parameter"
        and variable.type in TYPES
        and not variable.dimensions
        and variable.start is not None
    }
    chosen = list(every) if patterns is None else _matching(every, patterns, ParameterError)
    return [
        Shown(
            name,
            "TUNABLE" if variable.variability == "tunable" else "PARAMETER",
            TYPES[variable.type],
            name,
            system.unit_of(name),
            system.parameters.get(name, variable.start),
            variable.minimum,
            variable.maximum,
            variable.nominal,
            variable.description,
        )
        for name, variable in ((name, every[name]) for name in chosen)
    ]


def _matching(
    every: dict[str, Variable],
    patterns: Sequence[str],
    error: type[ConnectionFault] | type[ParameterError],
) -> list[str]:
    chosen: dict[str, None] = {}
    for pattern in patterns:
        found = [name for name in every if name == pattern or fnmatchcase(name, pattern)]
        if not found:
            near = suggestion(pattern, every)
            raise error(f"{pattern!r} matches nothing that a container can expose{near}")
        chosen |= dict.fromkeys(found)
    return list(chosen)
