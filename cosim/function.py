"""A Python function as a component of a system, stepped by the same kernel as FMUs."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from ctypes import CFUNCTYPE, POINTER, c_char_p, c_double, c_int, c_size_t, c_uint32, c_void_p
from itertools import count
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from stickslip.cosim.component import Component, check_name
from stickslip.cosim.errors import ConnectionFault
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.signals.signals import Array
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Variable
from stickslip.fmi.messages import shown

_OK, _ERROR = 0, 3  # of fmi2Status
_VALUES = (c_void_p, POINTER(c_uint32), c_size_t, POINTER(c_double))
_STATE = (c_void_p, POINTER(c_void_p))
# For each FMI function the method that serves it and the arguments.
_FUNCTIONS: dict[str, tuple[str, Sequence[Any]]] = {
    "Reset": ("_reset", (c_void_p,)),
    "SetupExperiment": ("_set_start", (c_void_p, c_int, c_double, c_double, c_int, c_double)),
    "EnterInitializationMode": ("_pass", (c_void_p,)),
    "ExitInitializationMode": ("_pass", (c_void_p,)),
    "Terminate": ("_pass", (c_void_p,)),
    "SetReal": ("_set", _VALUES),
    "GetReal": ("_get", _VALUES),
    "DoStep": ("_do_step", (c_void_p, c_double, c_double, c_int)),
    "GetFMUstate": ("_save", _STATE),
    "SetFMUstate": ("_restore", (c_void_p, c_void_p)),
    "FreeFMUstate": ("_free", _STATE),
    "SerializedFMUstateSize": ("_size", (c_void_p, c_void_p, POINTER(c_size_t))),
    "SerializeFMUstate": ("_serialize", (c_void_p, c_void_p, c_void_p, c_size_t)),
    "DeSerializeFMUstate": ("_deserialize", (c_void_p, c_void_p, c_size_t, POINTER(c_void_p))),
}
_addresses = count(1)  # of instances and states, which the kernel never follows


class Function(Component):
    """A Python function with declared inputs and outputs, in place of an FMU.

    >>> system.add("gain", cosim.Function(lambda t, u: -2.0 * u["x"], {"x": "m"}, {"F": "N"}))

    It can be coupled, iterated, scaled and recorded as an FMU, and its state is saved.
    It runs in this process only: SSP files, containers and isolation need FMUs. It pickles where
    ``step`` does.

    Parameters
    ----------
    step : without a state ``step(t, u)``, which returns the outputs at the time t [s] from the
        inputs u (name -> float); with a state ``step(t, h, x, u)``, which returns the new state and
        the outputs at the end t [s] of a step of length h [s] that begins in the state x. At the
        start it is called with h = 0 for the first outputs, and the new state is not used. Outputs
        are name -> number, or the number itself where there is one output
    inputs, outputs : name -> unit, as its name or a Unit; None where it has none
    state : at the start, a number or an array; the function has to return new ones of its shape
        and must keep nothing else between two calls
    feedthrough : whether outputs depend on inputs without delay; by default where there is no state

    Raises
    ------
    ConnectionFault : when a name occurs twice or cannot be used, or there is no output
    """

    serializes = restores_state = varies_step = True

    def __init__(
        self,
        step: Callable[..., Any],
        inputs: Mapping[str, Unit | str | None],
        outputs: Mapping[str, Unit | str | None],
        state: float | Array | None = None,
        *,
        feedthrough: bool | None = None,
    ) -> None:
        self.step = step
        self.label = f"function {getattr(step, '__qualname__', type(step).__qualname__)}"
        self.identity = f"{self.label} of {getattr(step, '__module__', type(step).__module__)}"
        self.binary = Path(f"{self.identity} at {id(step):x}")
        self.inputs, self.outputs = tuple(inputs), tuple(outputs)
        self.state = None if state is None else np.array(state, dtype=np.float64)
        names = [*self.inputs, *self.outputs]
        wrong = [f"{shown(name)}: {fault}" for name in names if (fault := check_name(name))]
        if wrong or len(set(names)) < len(names) or not outputs:
            what = "; ".join(wrong) or "expected distinct inputs and at least one output"
            raise ConnectionFault(f"{self.label}: cannot have the variables {names}: {what}")
        first = 0 if self.state is None else self.state.size
        self.variables = {
            name: Variable(
                name,
                reference=first + i,
                type="Real",
                causality="input" if i < len(self.inputs) else "output",
                variability="continuous",
                unit=unit.name if isinstance(unit, Unit) else unit,
                start=0.0 if i < len(self.inputs) else None,
            )
            for i, (name, unit) in enumerate([*inputs.items(), *outputs.items()])
        }
        units = [*inputs.values(), *outputs.values()]
        self.units = {unit.name: unit for unit in units if isinstance(unit, Unit)}
        direct = self.state is None if feedthrough is None else feedthrough
        self.feedthrough = dict.fromkeys(outputs, frozenset(inputs if direct else ()))

    def __repr__(self) -> str:
        return f"Function({self.label})"

    def table(self) -> Library:
        """Return the functions behind which it is called, see Component."""
        return FunctionLibrary(self)

    def evaluate(self, t: float, h: float, x: Array, u: Mapping[str, float]) -> tuple[Array, Array]:
        """Return state and outputs (n,) at the end t of a step of h [s], or raise ValueError."""
        if self.state is None:
            new, y = x, self.step(t, u)
        else:
            new, y = self.step(t, h, x.reshape(self.state.shape)[()], u)
            new = np.asarray(new, dtype=np.float64)
            if new.shape != self.state.shape:
                raise ValueError(f"new state has shape {new.shape}, expected {self.state.shape}")
        if not isinstance(y, Mapping):
            y = dict.fromkeys(self.outputs[:1], y)
        if y.keys() != set(self.outputs):
            raise ValueError(f"returned the outputs {list(y)}, expected {list(self.outputs)}")
        return new.reshape(-1), np.array([float(y[name]) for name in self.outputs])


class FunctionLibrary(Library):
    """The table of FMI functions behind which the kernel calls a Python function.

    All of an instance is one array: state, inputs, outputs, the start time, and 1 until the first
    step is done.
    """

    def __init__(self, component: Function) -> None:
        self._component = component
        self._version, self.resources, self.lacks_reset = 2, "", ""
        self._n_state = 0 if component.state is None else component.state.size
        self._end_inputs = self._n_state + len(component.inputs)
        self._instances: dict[int, Array] = {}
        table = {
            name: CFUNCTYPE(c_int, *arguments)(self._guarded(getattr(self, method)))
            for name, (method, arguments) in _FUNCTIONS.items()
        }
        table["Instantiate"] = CFUNCTYPE(
            c_void_p, c_char_p, c_int, c_char_p, c_char_p, c_void_p, c_int, c_int
        )(lambda *_: self._new(self._start()))
        table["FreeInstance"] = CFUNCTYPE(None, c_void_p)(self._forget)
        self._library = SimpleNamespace(**{f"fmi2{n}": call for n, call in table.items()})
        self.calls = self._step_calls()

    def function(self, name: str) -> Any:
        """Return a function of the table for use from Python; it returns an FMI status."""
        return getattr(self._library, name)

    def _guarded(self, function: Callable[..., object]) -> Callable[..., int]:
        def call(*arguments: Any) -> int:
            try:
                function(*arguments)
            except BaseException as fault:  # noqa: BLE001 - raised again behind the kernel
                self.fault = fault
                return _ERROR
            return _OK

        return call

    def _start(self) -> Array:
        memory = np.zeros(self._end_inputs + len(self._component.outputs) + 2)
        if self._component.state is not None:
            memory[: self._n_state] = self._component.state.reshape(-1)
        memory[-1] = 1.0
        return memory

    def _new(self, memory: Array) -> int:
        address = next(_addresses)
        self._instances[address] = memory
        return address

    def _forget(self, address: int) -> None:
        self._instances.pop(address, None)

    def _evaluate(self, memory: Array, t: float, h: float) -> None:
        n, end = self._n_state, self._end_inputs
        u = dict(zip(self._component.inputs, memory[n:end].tolist(), strict=True))
        x, memory[end:-2] = self._component.evaluate(t, h, memory[:n].copy(), u)
        if h:
            memory[:n] = x

    def _reset(self, instance: int) -> None:
        self._instances[instance][:] = self._start()

    def _set_start(self, instance: int, *times: float) -> None:
        self._instances[instance][-2] = times[2]

    def _pass(self, instance: int) -> None: ...

    def _set(self, instance: int, references: Any, n: int, values: Any) -> None:
        memory = self._instances[instance]
        for i in range(n):
            memory[references[i]] = values[i]

    def _get(self, instance: int, references: Any, n: int, values: Any) -> None:
        memory = self._instances[instance]
        if memory[-1]:
            self._evaluate(memory, memory[-2], 0.0)
        for i in range(n):
            values[i] = memory[references[i]]

    def _do_step(self, instance: int, t: float, h: float, _: int) -> None:
        self._evaluate(self._instances[instance], t + h, h)
        self._instances[instance][-1] = 0.0

    def _save(self, instance: int, state: Any) -> None:
        memory = self._instances[instance].copy()
        if state[0] in self._instances:
            self._instances[state[0]] = memory
        else:
            state[0] = self._new(memory)

    def _restore(self, instance: int, state: int) -> None:
        self._instances[instance][:] = self._instances[state]

    def _free(self, _: int, state: Any) -> None:
        self._forget(state[0])
        state[0] = None

    def _size(self, _: int, state: int, size: Any) -> None:
        size[0] = self._instances[state].nbytes

    def _serialize(self, _: int, state: int, room: int, size: int) -> None:
        ctypes.memmove(room, self._instances[state].tobytes(), size)

    def _deserialize(self, _: int, room: int, size: int, state: Any) -> None:
        memory = np.frombuffer(ctypes.string_at(room, size)).copy()
        if memory.shape != self._start().shape:
            raise ValueError(f"a state of {size} bytes is of another function")
        state[0] = self._new(memory)
