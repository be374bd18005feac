"""An FMU of Model Exchange as the functions dx/dt = f(t, x, u) and y = g(t, x, u)."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model
from fmpy.fmi3 import FMU3Model, fmi3Float64
from numpy.typing import NDArray

from stickslip.cosim.errors import LinearisationError
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.fmu.values import converted
from stickslip.cosim.kernel.arithmetic import plain_arithmetic
from stickslip.fmi.description.attributes import flag

Array = NDArray[np.float64]
_MOST_EVENTS = 1000


class Exchange:
    """One instance, initialised; it stays in the mode (of its events) in which it was put.

    Attributes
    ----------
    inputs, outputs, states : names of the n, m and p variables
    u0, x0 : their values after initialisation
    u_size, x_size : nominal values
    dt : 0, for it is in continuous time
    change : of a variable's size, for differences

    Raises
    ------
    LinearisationError
        When the FMU has arrays, or does not initialise.
    """

    dt = 0.0
    prefix = ""
    change = float(np.cbrt(np.finfo(float).eps))  # balances rounding and curvature

    @plain_arithmetic()
    def __init__(self, fmu: Fmu, parameters: Mapping[str, object], outputs: Sequence[str]) -> None:
        if fmu.has_arrays:
            raise LinearisationError(f"{fmu.path}: it has arrays; only scalars are supported here")
        derivatives = fmu.description.derivatives
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
    def rates(self, t: float, x: Array, u: Array) -> Array:
        """Return f, (n,)."""
        self._set(x, u, t)
        dx = (fmi3Float64 * len(x))()
        if self._version3:
            self._api.getContinuousStateDerivatives(dx, len(x))
        else:
            self._api.getDerivatives(dx, len(x))
        return np.array(dx)

    @plain_arithmetic()
    def shown(self, t: float, x: Array, u: Array) -> Array:
        """Return g, (p,)."""
        self._set(x, u, t)
        return self._get(self.outputs)

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

    def _set(self, x: Array, u: Array, t: float = 0.0) -> None:
        self._api.setTime(t)
        if len(x):
            self._api.setContinuousStates((fmi3Float64 * len(x))(*x), len(x))
        references = [self._references[name] for name in self.inputs]
        (self._api.setFloat64 if self._version3 else self._api.setReal)(references, list(u))

    def _get(self, names: tuple[str, ...]) -> Array:
        references = [self._references[name] for name in names]
        get = self._api.getFloat64 if self._version3 else self._api.getReal
        return np.array(get(references), dtype=float)
