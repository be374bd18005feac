"""What is linearised, here or in a process of its own."""

from __future__ import annotations

import weakref
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from stickslip.cosim.control.exchange import Array, Exchange
from stickslip.cosim.control.step_map import StepMap
from stickslip.cosim.errors import FmuCrashed
from stickslip.cosim.isolation.process import Process
from stickslip.cosim.run.exclusive import Exclusive
from stickslip.cosim.system.coupling import Coupling
from stickslip.cosim.system.isolation import Isolation
from stickslip.cosim.system.loops import group
from stickslip.cosim.system.system import Specification

_TEXTS = ("inputs", "outputs", "states")
_NUMBERS = ("x0", "u0", "x_size", "u_size")
_there: list[Exchange | StepMap] = []
"""In the child: the one that it has."""


def dynamics(
    spec: Specification,
    outputs: Sequence[str],
    prefix: str = "",
    parameters: Mapping[str, object] | None = None,
) -> Dynamics:
    """Return the functions of a system over a step, or of its FMU ``fmu`` by Model Exchange.

    Parameters
    ----------
    prefix : see ``StepMap``
    parameters : start values, for Model Exchange
    """
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

    def rates(self, t: float, x: Array, u: Array) -> Array:
        """Return f, (n,)."""
        return np.array(self._call(_ask, ("rates", t, x, u)), dtype=float)

    def shown(self, t: float, x: Array, u: Array) -> Array:
        """Return g, (p,)."""
        return np.array(self._call(_ask, ("shown", t, x, u)), dtype=float)

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
