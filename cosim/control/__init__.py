"""FMUs and python-control: linear models, at an operating point, and measured frequency responses.

What python-control designs is linear; friction, quantisation and limits are not. So the response,
measured sine by sine, depends on the amplitude: it is a describing function.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import control
import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip.cosim.control.dynamics import Dynamics, dynamics
from stickslip.cosim.control.step_map import alone
from stickslip.cosim.errors import ExperimentError, LinearisationError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.run.result import Result
from stickslip.cosim.signals.signals import Array, Input
from stickslip.cosim.system.settings import Isolated
from stickslip.cosim.system.system import Specification, System
from stickslip.fmi.by_name import by_name
from stickslip.fmi.messages import suggestion

__all__ = ["LinearisationError", "MeasuredResponse", "linearise", "measure_response"]


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
    LinearisationError : when a name is unknown, there are no states, or, over a step, there are
        others than those that can be set: declared ones, or such that show when runs of up to 512
        steps are started again on the way
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
        why = "for it has no Model Exchange: give step= [s]"
        raise LinearisationError(f"{what} can be linearised over a step only, {why}")
    return step


def _chosen(wanted: Sequence[str] | None, known: Sequence[str]) -> tuple[str, ...]:
    for name in wanted or ():
        if name not in known:
            raise LinearisationError(f"there is no output {name!r}{suggestion(name, known)}")
    return tuple(known if wanted is None else wanted)


def _point(names: Sequence[str], at: Array, values: Mapping[str, float] | None, what: str) -> Array:
    point = dict(zip(names, at, strict=True))
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
            ends.append((end, dynamics.values(*parts)))
        (high, above), (low, below) = ends
        columns.append((above - below) / (high - low))
    return np.array(columns).T


ComplexArray = NDArray[np.complex128]
_LEAST = 4  # samples in a period
_MOST = 500_000  # steps in which a system settles
_TINY = float(np.finfo(float).tiny)
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class MeasuredResponse:
    """Fundamentals of signals under a sine at an input.

    Attributes
    ----------
    input : its name
    amplitude : of the sine, in the unit of the input
    f : (n,) frequencies [Hz]
    step : communication step [s]
    fundamentals : signal -> (n,) complex amplitudes in its unit, the input's among them
    distortion : signal -> (n,) RMS of all that is not fundamental, relative to that of it [1]
    drift : signal -> (n,) change of the fundamental from one half of what is evaluated to the
        other, relative to it [1]: large where the system had not settled
    """

    input: str
    amplitude: float
    f: Array
    step: float
    fundamentals: Mapping[str, ComplexArray]
    distortion: Mapping[str, Array]
    drift: Mapping[str, Array]

    def response(self, output: str, source: str | None = None) -> ComplexArray:
        """Return the response from a signal, the input by default, to another, (n,)."""
        return self.fundamentals[output] / self.fundamentals[source or self.input]

    def frd(self, output: str, source: str | None = None) -> control.FrequencyResponseData:
        """Return the response for python-control: sampled, at angular frequencies [rad/s]."""
        return control.frd(self.response(output, source), 2 * np.pi * self.f, dt=self.step)


def measure_response(
    system: System,
    input: str,  # noqa: A002 - the word of control
    outputs: Sequence[str],
    f: ArrayLike,
    amplitude: float,
    *,
    step: float,
    periods: int = 8,
    settle: float = 0.2,
    settled: float = 1e-3,
    longest: float | None = None,
    offset: float = 0.0,
    inputs: Mapping[str, Input] | None = None,
    parameters: Mapping[str, object] | None = None,
    isolation: Isolated = "foreign",
) -> MeasuredResponse:
    """Run a system once for each frequency, with a sine at one input.

    The samples evaluated are whole periods, so that harmonics and a mean do not leak in: each
    frequency is moved to the nearest for which ``periods`` of it are a whole number of steps.

    Parameters
    ----------
    input : an exposed input
    outputs : signals to evaluate, ``component.variable``
    f : (n,) frequencies [Hz], at most a quarter of the sample rate
    amplitude, offset : of the sine, in the unit of the input
    step : communication step, and sample period of what is evaluated [s]
    periods : evaluated at each frequency, an even number
    settle : time before that, rounded up to whole periods, at least one [s]. It is doubled until
        the system has settled: until each fundamental is within ``settled`` what it is when it is
        evaluated half of this time earlier
    settled : change of the fundamentals, relative to them, over the second half of the settling [1]
    longest : time beyond which it is not doubled, with a warning [s]; 500,000 steps by default
    inputs, parameters : of every run, as for ``Simulation.run``
    isolation : which FMUs live in a process of their own, see ``System.prepare``

    Raises
    ------
    ExperimentError : when a frequency is too high or not positive, or ``periods`` is not even
    SimulationError, ParameterError, SignalError
    """
    wanted = np.atleast_1d(np.asarray(f, dtype=float))
    if periods < 2 or periods % 2:
        raise ExperimentError(f"periods is {periods}; expected an even number, 2 or more")
    if not wanted.size:
        raise ExperimentError("frequencies: expected one or more, got none")
    if not ((wanted > 0.0) & (wanted * step <= 1 / _LEAST)).all():
        what = f"{1 / (_LEAST * step):g} Hz, a quarter of the sample rate"
        advice = f"got {wanted.min():g} to {wanted.max():g} Hz"
        raise ExperimentError(f"frequencies must lie above 0 and up to {what}; {advice}")
    names = [input, *outputs]
    found: list[ComplexArray] = []
    reached = np.empty_like(wanted)
    for k, frequency in enumerate(wanted):
        n = 2 * round(periods / (2 * frequency * step))
        reached[k] = periods / (n * step)
        before = int(np.ceil(max(settle * reached[k], 1.0) * n / periods))
        while True:
            stop = (before + n) * step
            with system.prepare(
                step=step, stop=stop, record=names, isolation=isolation
            ) as simulation:
                sine = offset + amplitude * np.sin(2 * np.pi * reached[k] * simulation.time)
                result = simulation.run(parameters, {**(inputs or {}), input: sine})
            evaluated = _evaluated(result, names, before, n, periods)
            earlier = _evaluated(result, names, before // 2, n, periods)
            change = abs(evaluated - earlier)[:, 0] / np.maximum(abs(evaluated[:, 0]), _TINY)
            if change.max() <= settled:
                break
            if 2 * before * step > (_MOST * step if longest is None else longest):
                _log.warning(
                    "at %.6g Hz %s has not settled after %.6g s: its fundamental changes by %.2g",
                    reached[k],
                    names[int(change.argmax())],
                    before * step,
                    change.max(),
                )
                break
            before *= 2
        found.append(evaluated)
    fundamental, distortion, drift = np.moveaxis(np.array(found), 2, 0)  # each (frequencies, names)
    by_name: list[dict[str, NDArray[Any]]] = [
        dict(zip(names, values.T, strict=True))
        for values in (fundamental, distortion.real, drift.real)
    ]
    return MeasuredResponse(input, amplitude, reached, step, *by_name)


def _evaluated(
    result: Result, names: Sequence[str], before: int, n: int, periods: int
) -> ComplexArray:
    """Return fundamental, distortion and drift of each signal, (names, 3)."""
    turns = np.exp(-2j * np.pi * periods * np.arange(before, before + n) / n)
    rows = []
    for name in names:
        x = result[name][before : before + n]
        first, second = (2 / len(half) * half @ turns[: n // 2] for half in np.split(x, 2))
        fundamental = 0.5 * (first + second)
        size = abs(fundamental) or _TINY
        rest = np.sqrt(max(np.var(x) - 0.5 * abs(fundamental) ** 2, 0.0))
        rows.append((fundamental, rest / (size / np.sqrt(2)), abs(second - first) / size))
    return np.array(rows)
