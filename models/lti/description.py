"""A linear system as a model of the exporter: its variables, and what documents it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np

from stickslip.models.export.description import Kind, Model, Role, Variable
from stickslip.models.lti.system import Array, LinearSystem

# Axes and a step response.
_ICON = ((16, 14, 16, 82, 86, 82), (16, 82, 26, 56, 36, 34, 46, 27, 56, 31, 66, 36, 86, 36))
_README = """# {name}: a linear system

{equations}
{states} states{x0}, {time}.

| symbol | unit | meaning |
|---|---|---|
{rows}
"""
_EQUATIONS = {
    True: "    x+ = A x + B u\n     y = C x + D u\n",
    False: "    dx/dt = A x + B u\n        y = C x + D u\n",
}


def has_derivatives(system: LinearSystem) -> bool:
    """Tell whether there are differential equations with inputs: what Model Exchange is for."""
    return not system.dt and bool(system.states) and bool(system.inputs)


def model_of(system: LinearSystem, step: float, stop: float, folder: Path) -> Model:
    """Return the system as the exporter takes it; ``folder`` has its C and README.md."""
    shapes: dict[Role, tuple[str, int]] = {
        "input": ("u", len(system.inputs)),
        "state": ("x", len(system.states)),
        "derivative": ("x", len(system.states) * has_derivatives(system)),
        "output": ("y", len(system.outputs)),
    }
    fields: dict[Role, tuple[tuple[str, tuple[int, ...]], ...]] = {"memory": (), "parameter": ()}
    fields |= {role: ((name, (n,)),) if n else () for role, (name, n) in shapes.items()}
    if system.dt:
        fields["memory"] = (("k", ()), ("y", (len(system.outputs),)))
    return Model(
        name=system.name,
        title="Linear system",
        description=f"{len(system.states)} states, {_time(system)}",
        version="1.0",
        stop=stop,
        step=step,
        sampled=False,
        variables=tuple(_variables(system)),
        fields=fields,
        terminals={},
        icon=_ICON,
        folder=folder,
    )


def readme(system: LinearSystem) -> str:
    """Return README.md: equations and variables."""
    kinds = {"input": system.inputs, "state": system.states, "output": system.outputs}
    return _README.format(
        name=system.name,
        equations=_EQUATIONS[bool(system.dt)],
        states=len(system.states),
        x0=f" beginning at {system.x0.tolist()}" if system.x0.any() else "",
        time=_time(system),
        rows="\n".join(
            f"| `{name}` | {unit or ''} | {kind} |"
            for kind, variables in kinds.items()
            for name, unit in variables.items()
        ),
    )


def _time(system: LinearSystem) -> str:
    return f"sampled every {system.dt:g} s" if system.dt else "in continuous time"


def _variables(system: LinearSystem) -> Iterator[Variable]:
    """Yield the variables in value-reference order."""
    yield Variable("time", "time", "Simulation time", unit="s")
    for name, unit in system.inputs.items():
        yield Variable(name, "input", "Input", unit=unit)
    kind = "discrete" if system.dt else "continuous"
    for (name, unit), start in zip(system.states.items(), system.x0, strict=True):
        yield Variable(name, "state", "State", unit=unit, start=float(start), variability=kind)
    if has_derivatives(system):
        for (name, unit), a, b in zip(system.states.items(), system.A, system.B, strict=True):
            yield Variable(
                f"der({name})",
                "derivative",
                f"Derivative of {name}",
                unit=f"{unit}/s" if unit else None,
                depends={**_gains(system.inputs, b), **_gains(system.states, a)},
                of=name,
            )
    for (name, unit), c, d in zip(system.outputs.items(), system.C, system.D, strict=True):
        by_state = _gains(system.states, c)
        moving = has_derivatives(system)
        yield Variable(
            name,
            "output",
            "Output",
            unit=unit,
            is_output=True,
            depends={**_gains(system.inputs, d), **(by_state if moving else {})},
            uses=() if moving else tuple(by_state),
        )
    if system.dt:
        memory = {"sample": "1"} | {f"held.{name}": unit for name, unit in system.outputs.items()}
        for name, unit in memory.items():
            yield Variable(name, "memory", "Between samples", unit=unit, variability="discrete")


def _gains(names: Mapping[str, str | None], row: Array) -> dict[str, Kind]:
    return {name: "constant" for name, gain in zip(names, row, strict=True) if np.any(gain)}
