"""What a container shows of its system: inputs, outputs and parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Literal

from stickslip.cosim.errors import ConnectionFault, CosimError, ParameterError
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


# What passes through the kernel as a number, and has a value in both standards.
_SIGNALS = TYPES | dict.fromkeys(("Int8", "UInt8", "Int16", "UInt16", "Enumeration"), "INTEGER")
_SIGNALS["Float32"] = "REAL"


@dataclass(frozen=True)
class ContainerVariable:
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
) -> list[ContainerVariable]:
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
    time = ContainerVariable("time", "TIME", "REAL", unit=second, description="Simulation time")
    inputs = [_input(system, name) for name in system.inputs]
    return [time, *inputs, *_outputs(system, outputs), *_parameters(system, parameters)]


def _input(system: System, name: str) -> ContainerVariable:
    target = system.inputs[name][0]
    variable = system.variable(target)
    start = system.parameters.get(target, variable.start)
    unit, start = system.unit_of(name), 0.0 if start is None else start
    described = variable.description
    if variable.type not in _SIGNALS:
        raise ConnectionFault(
            f"input {name} is a {variable.type}, which a container does not show; leave it out"
        )
    return ContainerVariable(
        name, "INPUT", _SIGNALS[variable.type], name, unit, start, description=described
    )


def _outputs(system: System, patterns: Sequence[str] | None) -> list[ContainerVariable]:
    every = _variables(
        system, lambda v: v.causality == "output" and v.type in _SIGNALS and not v.dimensions
    )
    if hidden := [name for name, source in system.outputs.items() if source not in every]:
        raise ConnectionFault(
            f"output {hidden[0]} is an array or of a type that a container does not show"
        )
    names = dict(system.outputs) if patterns is None else {}
    if not names:
        names = {name: name for name in _matching(every, patterns, ConnectionFault)}
    return [_shown(system, name, "OUTPUT", every[source], source) for name, source in names.items()]


def _parameters(system: System, patterns: Sequence[str] | None) -> list[ContainerVariable]:
    def is_settable(v: Variable) -> bool:
        scalar = v.type in TYPES and not v.dimensions and v.start is not None
        return v.causality == "parameter" and scalar

    every = _variables(system, is_settable)
    chosen = {name: every[name] for name in _matching(every, patterns, ParameterError)}
    return [
        _shown(system, name, "TUNABLE" if v.variability == "tunable" else "PARAMETER", v, name)
        for name, v in chosen.items()
    ]


def _variables(system: System, wanted: Callable[[Variable], bool]) -> dict[str, Variable]:
    return {
        f"{component}.{variable.name}": variable
        for component, fmu in system.components.items()
        for variable in fmu.variables.values()
        if wanted(variable)
    }


def _shown(system: System, name: str, role: Role, v: Variable, source: str) -> ContainerVariable:
    start = None if role == "OUTPUT" else system.parameters.get(source, v.start)
    limits = (v.minimum, v.maximum, v.nominal)
    unit = system.unit_of(source)
    return ContainerVariable(
        name, role, _SIGNALS[v.type], source, unit, start, *limits, v.description
    )


def _matching(
    every: dict[str, Variable], patterns: Sequence[str] | None, error: type[CosimError]
) -> list[str]:
    chosen: dict[str, None] = dict.fromkeys(every if patterns is None else ())
    for pattern in patterns or ():
        found = [name for name in every if name == pattern or fnmatchcase(name, pattern)]
        if not found:
            near = suggestion(pattern, every)
            raise error(f"{pattern!r} matches nothing that a container can expose{near}")
        chosen |= dict.fromkeys(found)
    return list(chosen)
