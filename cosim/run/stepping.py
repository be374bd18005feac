"""A run from its begin to its end, to the point where it halts, or step by step."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from stickslip.cosim import kernel
from stickslip.cosim.assembly.inputs import (
    InputEvents,
    courses,
    put_inputs,
    sample_ends,
    sample_inputs,
    tune,
)
from stickslip.cosim.component import component_of
from stickslip.cosim.errors import ExperimentError, SimulationError
from stickslip.cosim.fmu.instance import Batch
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel import structures
from stickslip.cosim.run.instances import Instances
from stickslip.cosim.run.result import Result, Take
from stickslip.cosim.signals.signals import Array, Input, Table
from stickslip.fmi.description.variables import Value
from stickslip.fmi.process import check_interruption

_LAST_SUCCESSFUL_TIME, _TERMINATED = 2, 3  # of ``fmi2StatusKind``
_GETTERS = {2: "fmi2GetReal", 3: "fmi3GetFloat64"}


class Discarded(Exception):
    """A component discarded a step that it can do in parts, or refused derivatives of inputs."""

    def __init__(self, component: str, *, derivatives: bool = False) -> None:
        super().__init__(component)
        self.component, self.derivatives = component, derivatives


class NotReset(SimulationError):
    """The reset of a component failed; its instance is gone."""

    def __init__(self, component: str, message: str) -> None:
        super().__init__(message)
        self.component = component


class Stepper:
    """Takes FMUs through a run: by `follow`, `begin`, `go` and `advance`, or `start` and `step`.

    It has the start values of the run, and the names of parameters that change in it.
    """

    def __init__(self, fmus: Instances) -> None:
        self.fmus, self.plan, self._system = fmus, fmus.plan, fmus.plan.spec.system
        self.halted = self._by_steps = False
        self.starts: Mapping[str, Value] = {}
        self.changed: frozenset[str] = frozenset()
        self._varies_step = all(fmu.varies_step for fmu in self._system.components.values())
        recorded = self.plan.layout.recorded
        self._first_output = sum(name in self._system.inputs for name in recorded)

    def follow(
        self, values: Mapping[str, Value], inputs: Mapping[str, Input], tunable: Mapping[str, Input]
    ) -> Array:
        """Return the exposed inputs at the points in time; between them they are attached."""
        system, run = self._system, self.fmus.run
        time = self.plan.time if system.inputs else np.empty(0)
        external = sample_inputs(system, values, inputs, time)
        ends = sample_ends(system, inputs, time, external) if run.coupling else external
        self._tune(tunable, values)
        tables = {name: signal for name, signal in inputs.items() if isinstance(signal, Table)}
        run.n_events = run.event_end = 0
        if tables and not (run.coupling or run.constant_step) and self._varies_step:
            self._events = InputEvents(system, inputs, tables, time, external)
            self._events.attach(run)
        for name, general in self.fmus.general.items():
            general.follow(courses(system, name, tables))
        self.fmus.coupled.follow(ends)
        return external

    def _tune(self, tunable: Mapping[str, Input], values: Mapping[str, Value]) -> None:
        """Prepare the changes of parameters."""
        fmus, run = self.fmus, self.fmus.run
        self.starts, self.changed = values, frozenset(tunable)
        self._changes = tune(tunable, values, self.plan, fmus.libraries, fmus.general)
        run.n_changes = len(self._changes)
        run.changes = (structures.Change * run.n_changes)(*(c for _, c, _ in self._changes))

    def begin(self, values: Mapping[str, Value], external: Array, *, apart: bool = False) -> None:
        """Make FMUs, start values and memory, apart for a repetition, ready for a new run."""
        self.fmus.begin(values)
        self.fmus.memory.prepare(external, apart=apart)
        self.halted = self._by_steps = False

    def go(
        self,
        first: int,
        last: int,
        progress: Callable[[float], object] | None,
        take: Take | None = None,
    ) -> Result:
        """Step to the last of the points in time, and look up on the way if asked to.

        ``take`` is given all parts of the result but for the last, which is returned.
        """
        fmus, at = self.fmus, self.plan.at
        full = fmus.memory.prepare_part(first) if take else last
        self._texts = Texts([])
        look = last - first
        if progress:
            look = max(1, look // 100)
        halt = first
        try:
            if self.plan.layout.texts:
                look = look if self.plan.record.keep == "last" else 1
                self.advance(first)
            self._texts = self._new_texts()
            self._texts.note(at(first))
            while halt < last:
                halt = min(halt + look, last, full)
                if end := self.advance(halt):
                    return self._ended(end, first)
                self._texts.note(at(halt))
                if progress:
                    progress(at(halt))
                if take and halt == full < last:
                    take(self._result(*fmus.memory.kept(first, halt)))
                    self._texts.forget()
                    first = halt + 1
                    full = fmus.memory.prepare_part(first)
        finally:
            fmus.warn()
        return self._result(*fmus.memory.kept(first, last))

    def start(self, values: Mapping[str, Value], inputs: Mapping[str, float]) -> dict[str, float]:
        """Begin a run by steps; return the outputs at its start."""
        fmus, run, spec = self.fmus, self.fmus.run, self.plan.spec
        self._given = sample_inputs(self._system, values, inputs, np.array([spec.start]))
        self._tune({}, values)
        run.n_events = run.event_end = 0
        fmus.begin(values)
        fmus.memory.prepare_steps(self._given[0])
        fmus.coupled.follow(None)
        for general in fmus.general.values():
            general.follow({})
        self.halted = self._by_steps = False
        return self._stepped(0)

    def step(self, inputs: Mapping[str, float]) -> dict[str, float]:
        """Do one step of a run by steps; return the outputs at its end."""
        done = self.fmus.run.done
        self.fmus.drop_invalidated()
        if not (self._by_steps and self.fmus.ready):
            advice = "begin one with start()"
            raise SimulationError(f"{self._system.name}: expected a run by steps; {advice}")
        if done == self.plan.n_steps:
            raise ExperimentError(
                f"{self._system.name}: the run is at its stop, {self.plan.spec.stop:.9g} s; begin"
                " another one with start(), or prepare with a later stop"
            )
        if inputs:
            self._give(inputs)
        self._by_steps = False  # unless it comes to its end
        return self._stepped(done + 1)

    def _give(self, inputs: Mapping[str, float]) -> None:
        """Let exposed inputs have other values from now on."""
        system, run, table = self._system, self.fmus.run, self._given.copy()
        t = run.start + run.done * run.step
        put_inputs(system, inputs, np.array([t]), table)
        before, given, self._given = self._given[0], table[0], table
        if np.array_equal(given, before):
            return
        self.fmus.memory.give(given)
        self.fmus.coupled.jump(given)
        if self.fmus.general:
            jump = np.array([t - 1.0, t])
            tables = {
                name: Table(jump, np.array(values), held=True)
                for name, *values in zip(system.inputs, before, given, strict=True)
            }
            for name, general in self.fmus.general.items():
                general.jump(courses(system, name, tables), t)

    def _stepped(self, halt: int) -> dict[str, float]:
        try:
            end = self.advance(halt)
        finally:
            self.fmus.warn()
        if end:
            reached, reason = end
            name = self.plan.order[self.fmus.run.failed]
            advice = "begin another run with start()"
            raise SimulationError(f"{name}: {reason} at t = {reached:.9g} s; {advice}")
        self._by_steps = True
        names = self.plan.layout.recorded[self._first_output :]
        values = self.fmus.memory.last()[self._first_output :].tolist()
        return dict(zip(names, values, strict=True))

    def advance(self, halt: int) -> tuple[float, str] | None:
        """Step to a point in time; where an FMU ended the run, return when [s] and its reason."""
        fmus, run = self.fmus, self.fmus.run
        self.halted = False
        run.halt = halt
        outcome = kernel.PAUSED
        while outcome == kernel.PAUSED:  # once a second, so that Ctrl-C is served
            check_interruption()
            outcome = fmus.kernel.advance(run)
        self.halted = outcome == kernel.HALTED
        if outcome != kernel.FAILED:
            return None
        fmus.ready = False
        name = self.plan.order[run.failed]
        if end := self._end_by(name):
            return end
        if self._can_take_back(name):
            raise Discarded(name)
        if run.call == b"fmi2SetRealInputDerivatives" and run.status != kernel.FATAL:
            raise Discarded(name, derivatives=True)
        call, error = run.call, fmus.failure()
        raise NotReset(name, str(error)) if call.endswith(b"Reset") else error

    def _can_take_back(self, name: str) -> bool:
        """Whether the failure is a step that was discarded and has not been tried in parts."""
        fmu, general = self._system.components[name], self.fmus.general.get(name)
        call = (general.c.called if general else None) or self.fmus.run.call
        able = fmu.interface == "co_simulation" and fmu.restores_state and fmu.varies_step
        discarded = self.fmus.run.status == kernel.DISCARD and call.endswith(b"DoStep")
        return able and discarded and name not in self.fmus.retries

    def _end_by(self, name: str) -> tuple[float, str] | None:
        """Return when (s) a component that stopped the kernel ended the run; None if it failed."""
        run, slot, general = self.fmus.run, self.fmus.slots[name], self.fmus.general.get(name)
        if run.done < 0 or run.done >= run.n_steps or not slot.instance:
            return None
        if run.status == kernel.TERMINATED:
            reached = general.c.time if general else run.t + run.h
            return reached, "asked to terminate the simulation"
        if run.status == kernel.DISCARD and slot.version == 2:
            instance = general.c.instance if general else slot.instance
            ask = partial(_status, self.fmus.libraries[name], instance)
            if ask("fmi2GetBooleanStatus", _TERMINATED, ctypes.c_int32()):
                last = ask("fmi2GetRealStatus", _LAST_SUCCESSFUL_TIME, ctypes.c_double())
                reached = run.start + run.done * run.step if last is None else last
                return reached, "discarded a step, as it had terminated"
        return None

    def _ended(self, end: tuple[float, str], first: int) -> Result:
        """Return the partial result, from a step on, of a run that an FMU ended.

        In the last row, which is left out where the FMU came no further, only that FMU's outputs
        are new.
        """
        fmus, run = self.fmus, self.fmus.run
        name = self.plan.order[run.failed]
        time_reached, reason = end
        further = time_reached > run.start + run.done * run.step
        if further:
            slot = fmus.slots[name]
            fmus.memory.append(slot.column, last_outputs(slot))
        if not fmus.kernel.end_early(run, further):
            raise fmus.failure()
        time, values, points = fmus.memory.kept(first, run.done, ended=True)
        if further:
            time = np.append(time[:-1], time_reached)
        reason = f"{name}: {reason} at t = {time_reached:.9g} s"
        return self._result(time, values, points, reason)

    def _new_texts(self) -> Texts:
        names: dict[str, list[str]] = {}
        for name in self.plan.layout.texts:
            names.setdefault(component_of(name), []).append(name)
        batches = []
        for one, own in names.items():
            variables = [self._system.variable(name) for name in own]
            batch = Batch(self.fmus.libraries[one], variables, "Get")
            batches.append((own, batch, self.fmus.state_of(one).read))
        return Texts(batches)

    def _result(self, time: Array, rows: Array, points: int, stopped: str | None = None) -> Result:
        layout, changes = self.plan.layout, self._texts.changes
        kept = (time, rows, layout.recorded, self._system)
        return Result(*kept, stopped, changes, points, places=layout.places)


def last_outputs(slot: structures.Component) -> Array:
    """Return the outputs (n_outputs,) of an FMU at the end of its last step."""
    outputs = np.empty(slot.n_outputs)
    n = ctypes.c_size_t(len(outputs))
    arguments = [ctypes.c_void_p(slot.instance), slot.output_references, n, outputs.ctypes]
    get = structures.step_calls(slot.version).index(_GETTERS[slot.version])
    ctypes.CFUNCTYPE(ctypes.c_int)(slot.call[get])(*arguments, *[n] * (slot.version == 3))
    return outputs


def _status(library: Library, instance: int, name: str, kind: int, answer: Any) -> Any:
    """Return what an FMU says about its last step; None when it says nothing."""
    prototype = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_int, ctypes.c_void_p)
    status = prototype(library.address(name))(instance, kind, ctypes.byref(answer))
    return answer.value if status in {0, 1} else None


_MOST = 10_000_000  # characters of a run
_Reading = tuple[Sequence[str], Batch, Callable[[Batch], None]]


class Texts:
    """Reads strings at points in time and keeps those that differ from the ones before."""

    def __init__(self, batches: Sequence[_Reading]) -> None:
        self._batches = batches
        self._size = 0
        names = [name for names, _, _ in batches for name in names]
        self.changes: dict[str, list[tuple[float, str]]] = {name: [] for name in names}

    def forget(self) -> None:
        """Let go of all values but the present ones."""
        self.changes = {name: course[-1:] for name, course in self.changes.items()}
        self._size = sum(len(text) for ((_, text),) in self.changes.values())

    def note(self, time: float) -> None:
        """Read all strings at a point in time (s)."""
        for names, batch, read in self._batches:
            read(batch)
            for name, value in zip(names, batch.values, strict=True):
                text = (value or b"").decode(errors="replace")
                changes = self.changes[name]
                if changes and changes[-1][1] == text:
                    continue
                changes.append((float(time), text))
                self._size += len(text)
                if self._size > _MOST:
                    raise SimulationError(
                        f"{name}: the strings recorded up to t = {time:.9g} s have more than"
                        f" {_MOST:,} characters; record without them (--record)"
                    )
