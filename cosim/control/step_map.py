"""A system of FMUs over one communication step: x[k+1] = f(x[k], u[k]) and y[k] = g(x[k], u[k])."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from cosim.control.errors import LinearisationError
from cosim.fmu import Fmu
from cosim.system import System
from cosim.variables import Variable

Array = NDArray[np.float64]
_HIDDEN = 1e-2  # of the change over two steps: more than an integrator's tolerance explains
_TOLERANCE = 1e-6  # of an integrator, relative to the size of a state


class StepMap:
    """A prepared system that starts anew for every step. Attributes are as in ``Exchange``.

    Parameters
    ----------
    outputs : ``component.variable``
    step : communication step [s]
    prefix : that names of states and outputs have here and nowhere else

    Raises
    ------
    LinearisationError
        When it has no states that can be set.
    """

    change = 1e-3  # of a variable's size, for differences: an integrator inside adds noise

    def __init__(
        self, system: System, outputs: Sequence[str], step: float, prefix: str = ""
    ) -> None:
        self.dt, self.prefix = step, prefix
        self.inputs, self.outputs = tuple(system.inputs), tuple(outputs)
        variables = {
            f"{name}.{v.name}": v for name, fmu in system.components.items() for v in _states(fmu)
        }
        self.states = tuple(variables)
        if not self.states:
            raise LinearisationError(
                f"{system.name} has no states that can be set: continuous variables with a start"
                " value; measure its frequency response instead"
            )
        record = [*dict.fromkeys([*self.states, *self.outputs])]
        self._simulation = system.prepare(step=step, stop=2 * step, record=record)
        values = [system.parameters.get(name, v.start) for name, v in variables.items()]
        self.x0 = np.array([float(v) if isinstance(v, int | float) else 0.0 for v in values])
        self.x_size = np.array([abs(v.nominal or 1.0) for v in variables.values()])
        fed = [system.variable(targets[0]) for targets in system.inputs.values()]
        self.u0 = np.array([v.start if isinstance(v.start, float) else 0.0 for v in fed])
        self.u_size = np.array([abs(v.nominal or 1.0) for v in fed])

    def put(self, x: Array, u: Array) -> None:
        """Make sure that the states are all that a step begins with.

        Raises
        ------
        LinearisationError
            When two steps end elsewhere than one after the other from the states in between.
        """
        x, u, later = x + 1e-3 * self.x_size, u + 0.1 * self.u_size, u - 0.1 * self.u_size
        first, second = self._run(x, np.array([u, later, later]), self.states)[1:]
        again = self._run(first, later, self.states)[1]
        change = np.abs(first - x) + np.abs(second - first)
        off = np.abs(again - second) > _HIDDEN * change + _TOLERANCE * np.maximum(
            np.abs(x), self.x_size
        )
        if off.any():
            names = ", ".join(name for name, wrong in zip(self.states, off, strict=True) if wrong)
            raise LinearisationError(
                f"{self._simulation.spec.system.name} remembers more than its states, or counts"
                f" time: a second step of {self.dt:g} s takes {names} elsewhere; choose the step of"
                " what samples in it, or measure its frequency response instead"
            )

    def rates(self, t: float, x: Array, u: Array) -> Array:  # noqa: ARG002 - one face
        """Return f, (n,): the states after the step."""
        states: Array = self._run(x, u, self.states)[1]
        return states

    def shown(self, t: float, x: Array, u: Array) -> Array:  # noqa: ARG002 - one face
        """Return g, (p,)."""
        outputs: Array = self._run(x, u, self.outputs)[0]
        return outputs

    def jacobian(self, x: Array, u: Array) -> None:
        """Return None: a step has no derivatives of its own."""

    def _run(self, x: Array, u: Array, names: tuple[str, ...]) -> Array:
        start = dict(zip(self.states, map(float, x), strict=True))
        inputs = dict(zip(self.inputs, u.T, strict=True))
        result = self._simulation.run(start, inputs)
        return np.array([result[name] for name in names], dtype=float).T


def _states(fmu: Fmu) -> list[Variable]:
    """Return the states of an FMU: those it names, else what else has a start value and changes."""
    named = [state for state in fmu.description.derivatives.values() if state is not None]
    found = [fmu.variables[name] for name in named] or [
        v
        for v in fmu.variables.values()
        if v.causality in ("local", "output") and v.variability in ("continuous", "discrete")
    ]
    return [v for v in found if v.is_plain and v.initial == "exact"]


def alone(fmu: Fmu, parameters: Mapping[str, object]) -> System:
    """Return a system of one FMU, its inputs exposed under their own names."""
    system = System(fmu.name)
    system.add("fmu", fmu, parameters)
    for variable in fmu.variables.values():
        if variable.causality == "input" and variable.is_plain:
            system.expose(variable.name, f"fmu.{variable.name}")
    return system
