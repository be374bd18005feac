"""FMUs as systems of python-control: linearised at an operating point, or as they are."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence

import control
import numpy as np

from stickslip.cosim.control.dynamics import Dynamics, dynamics
from stickslip.cosim.control.step_map import alone
from stickslip.cosim.errors import LinearisationError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.system.settings import Isolated
from stickslip.cosim.system.system import Specification, System
from stickslip.fmi.by_name import by_name
from stickslip.fmi.messages import suggestion


def linearise(
    model: Fmu | System | str | os.PathLike[str],
    *,
    states: Mapping[str, float] | None = None,
    inputs: Mapping[str, float] | None = None,
    parameters: Mapping[str, object] | None = None,
    outputs: Sequence[str] | None = None,
    step: float | None = None,
    change: float | None = None,
    isolation: Isolated = "foreign",
) -> control.StateSpace:
    """Return an FMU or a system as a state space at an operating point.

    An FMU with Model Exchange becomes a system in continuous time: by its directional derivatives
    where it has them, else by central differences. With a ``step``, and where there is
    Co-Simulation only, a system in discrete time: by differences over one step, each started from
    each state.

    Parameters
    ----------
    model : an FMU or its path; or a system, whose exposed inputs are the inputs
    states, inputs : values at the operating point by name; those left out start as the FMU does
    parameters : start values
    outputs : to choose some; all, or those that the system exposes, by default
    step : communication step [s]; needed for a system and for Co-Simulation only
    change : by which share of its size (value or nominal value) a variable is moved for
        differences: 6e-6 for derivatives, 1e-3 over a step, where an integrator may add noise
    isolation : which FMUs live in a process of their own, see ``System.prepare``

    Returns
    -------
    StateSpace
        In deviations from the operating point, with ``dt`` = step, 0 in continuous time. Inputs,
        outputs and states keep their names, but for dots, which python-control does not take:
        ``component_variable``.

    Raises
    ------
    LinearisationError
        When a name is unknown, there are no states, or, over a step, there are others than those
        that can be set: declared ones, or such that show when runs of up to 512 steps are started
        again on the way.
    FmuError, SimulationError
    """
    found = _dynamics(model, parameters, outputs, step, isolation)
    names = _names(found)
    x = _point(names["states"], found.x0, states, "state")
    u = _point(names["inputs"], found.u0, inputs, "input")
    found.put(x, u)
    jacobian = found.jacobian(x, u)
    if jacobian is None:
        jacobian = _differences(found, x, u, change or found.change)
    n = len(x)
    return control.ss(
        *(jacobian[:n, :n], jacobian[:n, n:], jacobian[n:, :n], jacobian[n:, n:], found.dt),
        **_names(found, dot="_"),
    )


def nonlinear_system(
    model: Fmu | System | str | os.PathLike[str],
    *,
    parameters: Mapping[str, object] | None = None,
    outputs: Sequence[str] | None = None,
    step: float | None = None,
    isolation: Isolated = "foreign",
) -> control.NonlinearIOSystem:
    """Return an FMU or a system as a nonlinear I/O system of python-control.

    Arguments and errors are those of ``linearise``. In continuous time its events are not followed:
    it stays in the mode in which it starts. In discrete time every step is a run from its state.
    """
    found = _dynamics(model, parameters, outputs, step, isolation)
    found.put(found.x0, found.u0)
    return control.NonlinearIOSystem(
        lambda t, x, u, _: found.rates(t, np.atleast_1d(x), np.atleast_1d(u)),
        lambda t, x, u, _: found.shown(t, np.atleast_1d(x), np.atleast_1d(u)),
        dt=found.dt,
        **_names(found, dot="_"),
    )


def _dynamics(
    model: Fmu | System | str | os.PathLike[str],
    parameters: Mapping[str, object] | None,
    outputs: Sequence[str] | None,
    step: float | None,
    isolation: Isolated,
) -> Dynamics:
    parameters = by_name("parameters", parameters, LinearisationError)
    if not isinstance(model, Fmu | System):
        model = Fmu(model)
    if isinstance(model, Fmu):
        plain = [v.name for v in model.variables.values() if v.causality == "output" and v.is_plain]
        chosen = _chosen(outputs, plain)
        if step is None and "model_exchange" in model.interfaces:
            system = alone(Fmu(model.path, interface="model_exchange"), {})
            spec = Specification(system, 1.0, 2.0, isolation=isolation)
            return dynamics(spec, chosen, parameters=parameters)
        step = _needed(step, model.path)
        spec = Specification(alone(model, parameters), step, 2 * step, isolation=isolation)
        return dynamics(spec, [f"fmu.{name}" for name in chosen], "fmu.")
    system = model.copy()
    for name, value in parameters.items():
        system.set(name, value)
    fmus = system.fmus("linearisation")
    shown = system.outputs.values() or [
        f"{name}.{v.name}"
        for name, fmu in fmus.items()
        for v in fmu.variables.values()
        if v.causality == "output" and v.is_plain
    ]
    step = _needed(step, system.name)
    spec = Specification(system, step, 2 * step, isolation=isolation)
    return dynamics(spec, _chosen(outputs, [*shown]))


def _needed(step: float | None, what: object) -> float:
    if step is None:
        raise LinearisationError(
            f"{what} can be linearised over a step only, for it has no Model Exchange:"
            " give step= [s]"
        )
    return step


def _chosen(wanted: Sequence[str] | None, known: Sequence[str]) -> tuple[str, ...]:
    for name in wanted or ():
        if name not in known:
            raise LinearisationError(f"there is no output {name!r}{suggestion(name, known)}")
    return tuple(known if wanted is None else wanted)


def _point(
    names: Sequence[str], start: Array, values: Mapping[str, float] | None, what: str
) -> Array:
    point = dict(zip(names, start, strict=True))
    for name, value in by_name(f"{what}s", values, LinearisationError).items():
        if name not in point:
            raise LinearisationError(f"there is no {what} {name!r}{suggestion(name, point)}")
        point[name] = value
    return np.array([*point.values()], dtype=float)


def _names(dynamics: Dynamics, dot: str = ".") -> dict[str, list[str]]:
    """Return the names; python-control takes none with a dot."""
    named = {"inputs": dynamics.inputs, "outputs": dynamics.outputs, "states": dynamics.states}
    return {
        key: [name.removeprefix(dynamics.prefix).replace(".", dot) for name in names]
        for key, names in named.items()
    }


def _differences(dynamics: Dynamics, x: Array, u: Array, share: float) -> Array:
    """Return d(f, g) / d(x, u), (n + p, n + m), by central differences."""
    point = np.concatenate([x, u])
    sizes = np.maximum(np.abs(point), np.concatenate([dynamics.x_size, dynamics.u_size]))
    columns = []
    for k, change in enumerate(share * sizes):
        ends = []
        for end in (point[k] + change, point[k] - change):
            moved = point.copy()
            moved[k] = end
            parts = (moved[: len(x)], moved[len(x) :])
            values = [dynamics.rates(0.0, *parts), dynamics.shown(0.0, *parts)]
            ends.append((end, np.concatenate(values)))
        (high, above), (low, below) = ends
        columns.append((above - below) / (high - low))
    return np.array(columns).T
