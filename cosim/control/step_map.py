"""A system of FMUs over one communication step: x[k+1] = f(x[k], u[k]) and y[k] = g(x[k], u[k])."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from stickslip.cosim.errors import LinearisationError, SimulationError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.run.simulation import Simulation
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.system.system import System
from stickslip.fmi.description.variables import Variable

_HIDDEN = 1e-2  # of the range in two steps: more than an integrator's tolerance explains
_VISIBLE = 1e-3  # of the range in many, beside the errors that the integrator makes
_TOLERANCE = 1e-6  # of an integrator, relative to the size of a variable
_WINDOWS = 8, 64, 512  # steps in which a state that cannot be set comes to light
_MEASURE = "measure its frequency response (stickslip.cosim.control.measure_response) instead"
_INSTEAD = f"export it for Model Exchange and leave out step=, or {_MEASURE}"


class StepMap:
    """A prepared system that is initialised for every step. Attributes are as in ``Exchange``.

    ``prefix`` is what names of states and outputs have here and nowhere else.
    """

    change = 1e-3  # of a variable's size, for differences: an integrator inside adds noise

    def __init__(
        self, system: System, outputs: Sequence[str], step: float, prefix: str = ""
    ) -> None:
        self.dt, self.prefix = step, prefix
        self.inputs, self.outputs = tuple(system.inputs), tuple(outputs)
        variables = {
            f"{name}.{v.name}": v
            for name, fmu in system.fmus("linearisation").items()
            for v in _states(name, fmu)
        }
        self.states = tuple(variables)
        if not self.states:
            what = "continuous variables with a start value; measure its frequency response instead"
            raise LinearisationError(f"{system.name} has no states that can be set: {what}")
        self._watched = variables | {
            f"{name}.{v.name}": v
            for name, fmu in system.components.items()
            for v in fmu.variables.values()
            if v.causality == "output" and v.is_plain
        }
        record = tuple(dict.fromkeys([*self._watched, *self.outputs]))
        self._simulation = system.prepare(step=step, stop=2 * step, record=record, isolation=None)
        values = [system.parameters.get(name, v.start) for name, v in variables.items()]
        self.x0 = np.array([float(v) if isinstance(v, int | float) else 0.0 for v in values])
        self.x_size = np.array([abs(v.nominal or 1.0) for v in variables.values()])
        targets = [system.variable(targets[0]) for targets in system.inputs.values()]
        self.u0 = np.array([v.start if isinstance(v.start, float) else 0.0 for v in targets])
        self.u_size = np.array([abs(v.nominal or 1.0) for v in targets])

    def put(self, x: Array, u: Array) -> None:
        """Make sure that the states are all that a step begins with."""
        x, u, later = x + 1e-3 * self.x_size, u + 0.1 * self.u_size, u - 0.1 * self.u_size
        name, n = self._simulation.spec.system.name, len(x)
        two = self._run(x, [u, later, later], self._watched)
        ignored = np.abs(two[0, :n] - x) > _TOLERANCE * np.maximum(np.abs(x), self.x_size)
        if ignored.any():
            given = f"the given values of {', '.join(np.array(self.states)[ignored])}"
            raise LinearisationError(f"{name} does not start from {given}; {_INSTEAD}")
        one = self._run(two[1, :n], [later] * 3, self._watched)
        if names := self._off(two, two[2:], one[1:2], _HIDDEN):
            why = f"a second step of {self.dt:g} s takes {names} elsewhere"
            what = f"{name} remembers more than its states, or counts time: {why}"
            raise LinearisationError(f"{what}; choose the step of what samples in it, {_INSTEAD}")
        self._simulation.close()
        for steps in _WINDOWS:
            try:
                names = self._off_after(steps, x, u, later)
            except SimulationError:  # it does not go that far
                break
            if names:
                what = f"more than the states that can be set ({', '.join(self.states)})"
                why = f"after {steps} steps of {self.dt:g} s, a run that starts from them takes"
                raise LinearisationError(
                    f"{name} remembers {what}: {why} {names} elsewhere; {_INSTEAD}"
                )

    def _off_after(self, steps: int, x: Array, u: Array, later: Array) -> str:
        """Return what goes on otherwise when it is started again from its states at that time."""
        whole = self._course(0, x, [u] * steps + [later] * (steps + 1))
        again = self._course(steps, whole[steps, : len(x)], [later] * (steps + 1))
        if not self._off(whole, whole[steps + 1 :], again[1:], _VISIBLE):
            return ""
        # Started a step earlier, it would do the same but for its integrator's errors.
        earlier = self._course(steps - 1, whole[steps - 1, : len(x)], [u] + [later] * (steps + 1))
        errors = 3.0 * np.abs(earlier[2:] - again[1:]).max(axis=0)
        return self._off(whole, whole[steps + 1 :], again[1:], _VISIBLE, errors)

    def _course(self, begin: int, x: Array, u: Sequence[Array]) -> Array:
        """Return what is watched in a run that begins with a step, from there to its end."""
        times = begin * self.dt, (begin + len(u) - 1) * self.dt
        spec = replace(self._simulation.spec, start=times[0], stop=times[1])
        with spec.prepare() as simulation:
            return self._run(x, u, self._watched, simulation)

    def _off(
        self, course: Array, expected: Array, found: Array, share: float, errors: Any = 0.0
    ) -> str:
        """Return what differs by more than a share of its range in a run, and errors."""
        sizes = [abs(v.nominal or 1.0) for v in self._watched.values()]
        size = np.maximum(np.abs(course).max(axis=0), sizes)
        allowed = share * np.ptp(course, axis=0) + _TOLERANCE * size + errors
        off = np.abs(found - expected).max(axis=0) > allowed
        return ", ".join(name for name, wrong in zip(self._watched, off, strict=True) if wrong)

    def values(self, x: Array, u: Array) -> Array:
        """Return f, the states after the step, and g, (n + p,)."""
        run = self._run(x, [u] * 3, (*self.states, *self.outputs))
        return np.append(run[1, : len(x)], run[0, len(x) :])

    def jacobian(self, x: Array, u: Array) -> None:
        """Return None: a step has no derivatives of its own."""

    def _run(
        self,
        x: Array,
        u: Sequence[Array],
        names: Iterable[str],
        simulation: Simulation | None = None,
    ) -> Array:
        """Return what a run gives, (points, names), with inputs (m,) for each point in time."""
        start = dict(zip(self.states, map(float, x), strict=True))
        inputs = dict(zip(self.inputs, np.array(u).T, strict=True))
        result = (simulation or self._simulation).run(start, inputs)
        return np.array([result[name] for name in names], dtype=float).T


def _states(component: str, fmu: Fmu) -> list[Variable]:
    """Return the states of an FMU: those it names, else what else has a start value and changes."""
    named = fmu.description.derivatives or fmu.description.derivative_of
    if not named:
        return [
            v
            for v in fmu.variables.values()
            if v.causality in ("local", "output")
            and v.variability in ("continuous", "discrete")
            and _is_settable(v)
        ]
    lost = [
        f"the state of {rate}" if state is None else state
        for rate, state in named.items()
        if state is None or not _is_settable(fmu.variables[state])
    ]
    if lost:
        instead = _INSTEAD
        if "model_exchange" in fmu.interfaces:
            instead = f"linearise its Model Exchange by leaving out step=, or {_MEASURE}"
        what = f"a step cannot start from a given value of {', '.join(lost)}"
        advice = f"expected a scalar of 64 bits with initial=exact; {instead}"
        raise LinearisationError(f"{component} ({fmu.path.name}): {what}, {advice}")
    return [fmu.variables[state] for state in dict.fromkeys(named.values()) if state is not None]


def _is_settable(variable: Variable) -> bool:
    return variable.is_plain and variable.initial == "exact"


def alone(fmu: Fmu, parameters: Mapping[str, object]) -> System:
    """Return a system of one FMU, its inputs exposed under their own names."""
    system = System(fmu.name)
    system.add("fmu", fmu, parameters)
    for variable in fmu.variables.values():
        if variable.causality == "input" and variable.is_plain:
            system.expose(variable.name, f"fmu.{variable.name}")
    return system
