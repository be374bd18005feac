"""The bench an FMU is tried on: makes instances, knows what may be read, set and varied."""

import ctypes
import math
import time
from collections.abc import Callable, Iterable, Iterator
from ctypes import byref, c_bool, c_char_p, c_int, c_size_t, c_void_p
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeVar

from stickslip.fmucheck.description.model import Description, Interface, Variable, is_number, number
from stickslip.fmucheck.rules import Claims
from stickslip.fmucheck.running import calls
from stickslip.fmucheck.running.instance import Instance

Settings = list[tuple[str, object]]
"""Settings of a process by name."""
Thing = TypeVar("Thing")
PATIENCE = 8.0  # s for one rule that tries one thing after the other
MOST_READ = 500  # variables read at every step


class Spent(Exception):
    """A further instance is needed where the FMU allows one per process."""


@dataclass(eq=False)
class Bench:
    """One interface of one FMU, to be tried.

    ``first`` is what an earlier process found out, for rules that compare two processes.
    """

    description: Description
    interface: Interface
    library: Path
    resources: Path
    before: Settings  # settings of the process before the library was loaded
    first: dict[str, str] = field(default_factory=dict)
    results: dict[str, str] = field(default_factory=dict)  # what is found out, for a later process
    tick: Callable[[], None] = lambda: None  # tells the parent that work goes on
    began: float = 0.0  # when the rule that is being tried began, by the monotonic clock
    instantiated: bool = False  # whether an instance was made, or refused
    _open: list[Instance] = field(default_factory=list)

    @property
    def is_spent(self) -> bool:
        """Whether the FMU allows one instance per process, and this process has had it."""
        return self.instantiated and self.interface.flag("canBeInstantiatedOnlyOncePerProcess")

    @cached_property
    def binary(self) -> calls.Binary:
        """The loaded library."""
        return calls.Binary(self.library, self.description.version)

    @property
    def still(self) -> bool:
        """Whether inputs stay at their start values, because the FMU fails when they move."""
        return "still" in self.results

    @property
    def is_exchange(self) -> bool:
        """Whether this is Model Exchange."""
        return self.interface.kind == "ModelExchange"

    def instantiate(
        self, *, token: str | None = None, logging: bool = True, logger: bool = True
    ) -> Instance | None:
        """Return a new instance, None when refused; Spent when a process had its only one."""
        if self.is_spent:
            raise Spent
        self.instantiated = True
        self.tick()
        callbacks = calls.Callbacks(self.description.variables)
        given = (self.description.token if token is None else token).encode()
        log = callbacks.logger3 if logger else c_void_p()
        event_mode = self.interface.flag("hasEventMode")
        if self.description.version == 2:
            name, kind = "Instantiate", c_int(0 if self.is_exchange else 1)
            location = self.resources.absolute().as_uri().encode()
            arguments: list[Any] = [kind, c_char_p(given), c_char_p(location)]
            arguments += [byref(callbacks.functions), c_int(0), c_int(logging)]
        else:
            name = f"Instantiate{self.interface.kind}"
            folder = f"{self.resources}/".encode() if self.resources.is_dir() else None
            arguments = [c_char_p(given), c_char_p(folder), c_bool(False), c_bool(logging)]
            end: list[Any] = [c_void_p(callbacks.environment), log]
            if self.interface.kind == "CoSimulation":
                arguments += [c_bool(event_mode), c_bool(False), c_void_p(), c_size_t(0)]
                end.append(c_void_p())
            elif self.interface.kind == "ScheduledExecution":
                self._nothing = [ctypes.CFUNCTYPE(None)(lambda: None) for _ in range(3)]
                end += self._nothing
            arguments += end
        handle = self.binary.function(name, c_void_p)(c_char_p(b"fmucheck"), *arguments)
        if not handle:
            return None
        instance = Instance(self.binary, self.description, handle, callbacks)
        instance.event_mode = event_mode
        self._open.append(instance)
        return instance

    def new(self, *, logging: bool = True) -> Instance:
        """Return a new instance; CallFailed when the FMU refuses."""
        instance = self.instantiate(logging=logging)
        if instance is None:
            raise calls.CallFailed("instantiation", calls.FATAL, ": it gave no instance")
        return instance

    def last_words(self) -> str:
        """Return what the instance that failed has logged last, as half a sentence."""
        texts = [m.text for i in self._open if i.broken for m in i.callbacks.messages if m.text]
        return f"; its last message: {texts[-1][:200]}" if texts else ""

    def close(self) -> None:
        """Free every instance that is still in order; one after a failed call may hurt."""
        while self._open:
            instance = self._open.pop()
            if not instance.broken:
                instance.free()

    def free(self, instance: Instance) -> None:
        """Free one instance now."""
        self._open.remove(instance)
        instance.free()

    def failed(self, name: str, status: int) -> Claims:
        """Yield that a function failed, if it did."""
        if status > calls.WARNING:
            yield f"{self.binary.prefix}{name}", f"returned {calls.status_name(status)}"

    def while_time(self, things: Iterable[Thing]) -> Iterator[Thing]:
        """Yield things until the rule has taken long; fewer of them are tried on slow FMUs."""
        for thing in things:
            if time.monotonic() - self.began > PATIENCE:
                return
            yield thing

    def _readable(self, v: Variable) -> bool:
        return v.kind != "Clock" and v.clocks is None and v.reference is not None

    @cached_property
    def observed(self) -> list[Variable]:
        """What is read at every step: outputs and states first, then all others, up to a limit."""
        first = [v for v in self.description.variables if v.causality == "output"]
        every = dict.fromkeys([*first, *self.description.states, *self.description.variables])
        return [v for v in every if self._readable(v)][:MOST_READ]

    @cached_property
    def inputs(self) -> list[Variable]:
        """The inputs that can be moved as numbers or switches."""
        every = [v for v in self.description.variables if v.causality == "input"]
        return [v for v in every if self._readable(v) and v.kind not in ("String", "Binary")]

    @cached_property
    def parameters(self) -> list[Variable]:
        """The scalar numeric parameters that can be set before initialisation."""
        every = [v for v in self.description.variables if v.causality == "parameter"]
        numeric = [v for v in every if is_number(v.kind) and v.kind != "Enumeration"]
        return [v for v in numeric if self._readable(v) and not v.dimensions and v.start_numbers]

    @property
    def start_time(self) -> float:
        """Where runs begin, in s."""
        start = self.description.proposed("startTime")
        return float(start) if start is not None and math.isfinite(start) else 0.0

    @cached_property
    def step_size(self) -> float:
        """The communication step, in s."""
        step = self.description.proposed("stepSize")
        stop = self.description.proposed("stopTime")
        if step is None or not (0.0 < step < math.inf):
            span = (stop if stop is not None and stop < math.inf else 1.0) - self.start_time
            step = span / 100.0 if span > 0.0 else 0.01
        fixed = number(self.interface.given.get("fixedInternalStepSize"))
        if fixed is not None and 0.0 < fixed < math.inf:
            step = max(1.0, round(step / fixed)) * fixed
        return float(step)
