"""What is linearised, here or in a process of its own: Model Exchange, or one step."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model, fmi3Float64

from stickslip.cosim.component import converted
from stickslip.cosim.control.step_map import StepMap
from stickslip.cosim.errors import FmuCrashed, LinearisationError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.isolation.process import Process
from stickslip.cosim.kernel import plain_arithmetic
from stickslip.cosim.run.guards import Exclusive
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.system.loops import group
from stickslip.cosim.system.settings import Coupling, Isolation
from stickslip.cosim.system.system import Specification
from stickslip.fmi.description.attributes import flag

_MOST_EVENTS = 1000


class Exchange:
    """One instance, initialised; it stays in the mode (of its events) in which it was put.

    It has the names of inputs, outputs and states, the values u0 and x0 after initialisation,
    nominal values u_size and x_size, and which ``change`` of a size differences are to take.
    """

    dt = 0.0
    prefix = ""
    change = float(np.cbrt(np.finfo(float).eps))  # balances rounding and curvature

    @plain_arithmetic()
    def __init__(self, fmu: Fmu, parameters: Mapping[str, object], outputs: Sequence[str]) -> None:
        if fmu.has_arrays:
            raise LinearisationError(f"{fmu.path}: it has arrays; only scalars are supported here")
        derivatives = fmu.description.derivatives
        if fmu.description.standard == 1:
            what = "FMI 1.0 does not name states; export it again for FMI 2.0 or 3.0"
            raise LinearisationError(f"{fmu.path}: {what}")
        if None in derivatives.values():
            raise LinearisationError(f"{fmu.path}: it does not say what its derivatives are of")
        self._rates = [fmu.variables[name] for name in derivatives]
        signals = [v for v in fmu.variables.values() if v.is_plain]
        inputs = [v for v in signals if v.causality == "input"]
        self.states = tuple(state for state in derivatives.values() if state is not None)
        self.inputs, self.outputs = tuple(v.name for v in inputs), tuple(outputs)
        self._references = {v.name: v.reference for v in signals}
        self._fmu, self._version3 = fmu, fmu.version == 3
        provides = "providesDirectionalDerivative" + ("s" if self._version3 else "")
        interface = fmu.description.interfaces.get("ModelExchange", {})
        self._gives_derivatives = flag(interface, provides)
        self._api: Any = (FMU3Model if self._version3 else FMU2Model)(
            guid=fmu.token,
            modelIdentifier=fmu.identifier,
            unzipDirectory=str(fmu.folder),
            libraryPath=str(fmu.binary),
            instanceName=fmu.name,
        )
        try:
            self._initialise(parameters)
        except FMICallException as fault:
            raise LinearisationError(f"{fmu.path}: cannot be initialised: {fault}") from None
        weakref.finalize(self, plain_arithmetic()(self._api.freeInstance))
        x = (fmi3Float64 * len(self.states))()
        if len(x):
            self._api.getContinuousStates(x, len(x))
        self.x0 = np.array(x)
        self.u0 = self._get(self.inputs)
        moved = [*(fmu.variables[name] for name in self.states), *inputs]
        sizes = np.array([abs(v.nominal or 1.0) for v in moved])
        self.x_size, self.u_size = np.split(sizes, [len(self.states)])

    @plain_arithmetic()
    def put(self, x: Array, u: Array) -> None:
        """Go to an operating point and take the events that are due there."""
        self._set(x, u)
        self._api.enterEventMode()
        self._take_events()

    @plain_arithmetic()
    def values(self, x: Array, u: Array) -> Array:
        """Return f and g, (n + p,)."""
        self._set(x, u)
        dx = (fmi3Float64 * len(x))()
        if self._version3:
            self._api.getContinuousStateDerivatives(dx, len(x))
        else:
            self._api.getDerivatives(dx, len(x))
        return np.append(np.array(dx), self._get(self.outputs))

    @plain_arithmetic()
    def jacobian(self, x: Array, u: Array) -> Array | None:
        """Return d(f, g) / d(x, u), (n + p, n + m), as the FMU gives it; None when it does not."""
        if not self._gives_derivatives:
            return None
        self._set(x, u)
        unknowns = [rate.reference for rate in self._rates]
        unknowns += [self._references[name] for name in self.outputs]
        knowns = [self._fmu.variables[name].reference for name in (*self.states, *self.inputs)]
        columns = [self._api.getDirectionalDerivative(unknowns, [k], [1.0]) for k in knowns]
        return np.array(columns).T.reshape(len(unknowns), len(knowns))

    def _initialise(self, parameters: Mapping[str, object]) -> None:
        self._api.instantiate()
        if not self._version3:
            self._api.setupExperiment()
        for name, value in parameters.items():
            variable = self._fmu.find(name)
            if variable is None:
                raise LinearisationError(f"{self._fmu.path} has no variable {name!r}")
            kind = {"Enumeration": "Int64" if self._version3 else "Integer"}.get(variable.type)
            setter = getattr(self._api, f"set{kind or variable.type}")
            setter([variable.reference], [converted(variable, value, name)])
        self._api.enterInitializationMode()
        self._api.exitInitializationMode()
        self._take_events()

    def _take_events(self) -> None:
        update = self._api.updateDiscreteStates if self._version3 else self._api.newDiscreteStates
        for _ in range(_MOST_EVENTS):
            again, terminate, *_ = update()
            if terminate:
                raise LinearisationError(f"{self._fmu.path} asks to end at the operating point")
            if not again:
                break
        self._api.enterContinuousTimeMode()

    def _set(self, x: Array, u: Array) -> None:
        self._api.setTime(0.0)
        if len(x):
            self._api.setContinuousStates((fmi3Float64 * len(x))(*x), len(x))
        references = [self._references[name] for name in self.inputs]
        (self._api.setFloat64 if self._version3 else self._api.setReal)(references, list(u))

    def _get(self, names: tuple[str, ...]) -> Array:
        references = [self._references[name] for name in names]
        get = self._api.getFloat64 if self._version3 else self._api.getReal
        return np.array(get(references), dtype=float)


_TEXTS = ("inputs", "outputs", "states")
_NUMBERS = ("x0", "u0", "x_size", "u_size")
_there: list[Exchange | StepMap] = []  # in the child: the one that it has


def dynamics(
    spec: Specification,
    outputs: Sequence[str],
    prefix: str = "",
    parameters: Mapping[str, object] | None = None,
) -> Dynamics:
    """Return the functions of a system over a step, or with parameters those of its ``fmu``."""
    limits = spec.limits
    if limits is None:
        return _here(spec, outputs, prefix, parameters)
    return IsolatedDynamics(spec, limits, (outputs, prefix, parameters))


class IsolatedDynamics:
    """An Exchange or a StepMap that lives in a child process; attributes are as in ``Exchange``."""

    def __init__(self, spec: Specification, limits: Isolation, arguments: Sequence[Any]) -> None:
        groups = group(spec.system, Coupling.of(spec.coupling))
        order = [name for members in groups for name in members.components]
        self._exclusive = Exclusive(spec.system.name, outlives_fork=False)
        self._crash: FmuCrashed | None = None
        self._process = Process(spec, limits, order, 1, (__name__,))
        weakref.finalize(self, self._process.end)
        found = self._call(_begin, arguments)
        self.inputs, self.outputs, self.states = (tuple(found[name]) for name in _TEXTS)
        numbers: list[Array] = [np.array(found[name], dtype=float) for name in _NUMBERS]
        self.x0, self.u0, self.x_size, self.u_size = numbers
        self.dt, self.change = float(found["dt"]), float(found["change"])
        self.prefix = str(found["prefix"])

    def put(self, x: Array, u: Array) -> None:
        """Go to an operating point, see Exchange and StepMap."""
        self._call(_ask, ("put", x, u))

    def values(self, x: Array, u: Array) -> Array:
        """Return f and g, (n + p,)."""
        return np.array(self._call(_ask, ("values", x, u)), dtype=float)

    def jacobian(self, x: Array, u: Array) -> Array | None:
        """Return d(f, g) / d(x, u), (n + p, n + m), as the FMU gives it; None when it does not."""
        found = self._call(_ask, ("jacobian", x, u))
        rows, columns = len(x) + len(self.outputs), len(x) + len(u)
        return None if found is None else np.array(found, dtype=float).reshape(rows, columns)

    def _call(self, function: object, arguments: Sequence[Any]) -> Any:
        with self._exclusive:
            if self._crash:
                raise self._crash
            try:
                reply = self._process.ask("call", {"function": function, "arguments": arguments})
            except BaseException as error:  # also Ctrl-C: the child is in the middle of something
                self._crash = error if isinstance(error, FmuCrashed) else FmuCrashed("interrupted")
                self._process.end()
                raise
            return self._process.told(reply)["result"]


Dynamics = Exchange | StepMap | IsolatedDynamics


def _here(
    spec: Specification,
    outputs: Sequence[str],
    prefix: str,
    parameters: Mapping[str, object] | None,
) -> Exchange | StepMap:
    if parameters is None:
        return StepMap(spec.system, outputs, spec.step, prefix)
    return Exchange(spec.system.fmus("linearisation")["fmu"], parameters, outputs)


def _begin(spec: Specification, *arguments: Any) -> dict[str, Any]:
    """Make it in the child; return its attributes."""
    made = _here(spec, *arguments)
    _there.append(made)
    found = {name: getattr(made, name) for name in (*_TEXTS, "dt", "change", "prefix")}
    return found | {name: getattr(made, name).tolist() for name in _NUMBERS}


def _ask(_: Specification, name: str, *arguments: Any) -> list[Any] | None:
    found = getattr(_there[0], name)(*arguments)
    return None if found is None else found.tolist()
