"""A prepared system: FMUs instantiated once, run as often as you like."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Self

import numpy as np

from cosim import kernel
from cosim.checkpoint import Checkpoint
from cosim.coupled import Coupled
from cosim.coupling import Coupling, Method
from cosim.disturbances import disturb
from cosim.ending import Ending, ending, last_outputs
from cosim.errors import ExperimentError, SimulationError
from cosim.experiment import check_tolerance, count_steps
from cosim.kernel.unrolled import unroll
from cosim.layout import Layout
from cosim.library import Library
from cosim.loops import group
from cosim.memory import Memory
from cosim.once import claim, give_up
from cosim.pace import Pace
from cosim.record import Record
from cosim.result import Array, Result
from cosim.scenario import Scenario
from cosim.settings import Settings, check_length
from cosim.signals import Input, sample_inputs
from cosim.state import StateAccess
from cosim.tuning import in_order, split, tune
from cosim.variables import Value
from cosim.wiring import wire

if TYPE_CHECKING:
    from cosim.system import System


@dataclass(frozen=True)
class Specification:
    """All that makes a simulation; pickles, so that each worker can prepare its own.

    The fields are the arguments of ``System.prepare``.
    """

    system: System
    step: float
    stop: float
    start: float = 0.0
    record: Record | tuple[str, ...] | None = None
    coupling: Coupling | Method = "gauss_seidel"
    constant_step: bool = False
    compiled: bool = False
    tolerance: float | None = None

    def prepare(self) -> Simulation:
        """Instantiate the FMUs."""
        return Simulation(self)


class Simulation:
    """Runs a system. Life: ``prepare`` -> any number of ``run`` -> ``close`` (or ``with``).

    One thread at a time; other threads prepare their own from ``spec``. A run leaves the
    interpreter lock, so their runs go on side by side.

    Attributes
    ----------
    spec : Specification
    time : (n_steps + 1,) float64, s
    order : names of the components as they step
    pace : how well the last run kept real time, None when it did not have to
    """

    def __init__(self, spec: Specification) -> None:
        system = spec.system
        coupling = Coupling.of(spec.coupling)
        n_steps = count_steps(spec.start, spec.stop, spec.step)
        check_tolerance(spec.tolerance)
        jacobi = coupling.method == "jacobi"
        groups = group(system, coupling)
        self.spec = spec
        self.time: Array = spec.start + spec.step * np.arange(n_steps + 1, dtype=np.float64)
        self.pace: Pace | None = None
        self._halted = False
        self.order = [name for members in groups for name in members.components]
        record = Record.of(spec.record)
        self._layout = Layout.of(system, record)
        self._libraries = {name: Library(fmu) for name, fmu in system.components.items()}
        self._run, self._facades = wire(
            system,
            self._layout,
            self.order,
            self._libraries,
            jacobi=jacobi,
            tolerance=spec.tolerance,
        )
        self._kernel = kernel.load(unroll(self._run) if spec.compiled else None)
        self._coupled = Coupled(
            system, self._layout, groups, self._libraries, coupling, self._facades
        )
        self._run.constant_step = spec.constant_step
        self._run.n_steps = n_steps
        self._run.start, self._run.stop, self._run.step = spec.start, spec.stop, spec.step
        self._coupled.attach(self._run)
        self._memory = Memory(self._run, self._layout, record, self.time)
        self._slots = {name: self._run.components[i] for i, name in enumerate(self.order)}
        self._attach(self._new_settings(system.parameters))
        self._instantiate()

    def run(
        self,
        parameters: Mapping[str, object] | None = None,
        inputs: Mapping[str, Input] | None = None,
        *,
        scenario: Scenario | None = None,
        until: float | None = None,
        real_time: float | None = None,
        progress: Callable[[float], object] | None = None,
    ) -> Result:
        """Run from the start: reset, set start values, initialise, step.

        Parameters
        ----------
        parameters : ``component.variable`` -> start value for this run only
        inputs : exposed input -> array (n_steps + 1,), Signal, function of the time array, or
            number. The value at t[n] holds until t[n + 1]. An input left out keeps the start value
            of its first target
        scenario : what happens to signals on the way
        until : a point of ``time`` (s) to halt at, so that the state can be saved; the stop if
            left out
        real_time : simulated s per s; as fast as can be if left out. ``pace`` tells how well the
            clock was kept
        progress : is called with the time reached (s) now and then

        Raises
        ------
        ParameterError, SignalError
            Before anything is run.
        SimulationError
            When an FMU fails or gives a value that is not finite; the simulation can run again.

        An FMU may ask to end a run: the result is then shorter, and its ``stopped`` says so.
        """
        system = self.spec.system
        values: dict[str, Value] = dict(system.parameters)
        for name, value in (parameters or {}).items():
            values[name] = system.checked(name, value)
            check_length(system, name, values[name])
        external = sample_inputs(system, values, inputs or {}, self.time)
        self._disturb(scenario, external, values)
        self._begin(values, external)
        return self._step(0, self._place(until), real_time, progress)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the state that the last run halted in to a file, for ``resume``; return the path.

        Raises
        ------
        SimulationError
            When no run was halted by ``until``, or an FMU cannot give its state away.

        A resumed run equals the uninterrupted one bit for bit, but for Model Exchange: its solver
        starts anew, so that the two agree within its tolerance.
        """
        if not self._halted:
            raise SimulationError("there is no state to save: halt a run with run(until=...)")
        components = self.spec.system.components
        if mute := [name for name, fmu in components.items() if not fmu.serializes]:
            raise SimulationError(
                f"the state cannot be saved: {', '.join(mute)} cannot serialise it"
                " (canSerializeFMUstate)"
            )
        states = {name: self._state_of(name).save() for name in self.order}
        row = self._memory.state()
        memory = {f"/{name}": values for name, values in self._coupled.memory().items()}
        for owner, facade in self._facades.items():
            memory |= {f"{owner}/{name}": values for name, values in facade.memory().items()}
        starts = {n: float(v) for n, v in self._starts.items() if isinstance(v, int | float)}
        identity, done = self._identity(), self._run.done
        return Checkpoint(identity, done, row, states, starts, memory).write(path)

    def resume(
        self,
        path: str | os.PathLike[str],
        inputs: Mapping[str, Input] | None = None,
        *,
        scenario: Scenario | None = None,
        until: float | None = None,
        real_time: float | None = None,
        progress: Callable[[float], object] | None = None,
    ) -> Result:
        """Go on from a saved state; return what follows, the time of the state included.

        Arguments are those of ``run``; start values are in the state.

        Raises
        ------
        SimulationError
            Also when the state is of another system, step, start, coupling or record.
        """
        checkpoint = Checkpoint.read(path)
        if checkpoint.identity != self._identity():
            raise SimulationError(
                f"{path} was saved by another system, or with another step, start, coupling or"
                " record"
            )
        last = self._place(until)
        if last <= checkpoint.step:
            reached = self.spec.start + checkpoint.step * self.spec.step
            raise ExperimentError(
                f"{path} is at t = {reached:.9g} s already, there is no step left"
            )
        system = self.spec.system
        external = sample_inputs(system, system.parameters, inputs or {}, self.time)
        self._disturb(scenario, external, {**system.parameters, **checkpoint.starts})
        self._begin(system.parameters, external)
        self._advance(0)  # initialised, the FMUs are in a mode that takes a state
        for name in self.order:
            self._state_of(name).restore(checkpoint.states[name])
            self._recall(name, checkpoint)
        self._coupled.recall(checkpoint.memory_of(""))
        self._memory.go_on(checkpoint.step, checkpoint.row)
        return self._step(checkpoint.step, last, real_time, progress)

    def _disturb(
        self, scenario: Scenario | None, external: Array, values: Mapping[str, Value]
    ) -> None:
        run, system = self._run, self.spec.system
        self._starts = values
        if not (scenario or run.disturbed or run.n_changes):
            return
        tables = scenario.tables(self.time) if scenario else {}
        self._disturbances, changed = split(tables, self._layout, system)
        disturb(self._disturbances, self._layout, run, self._slots, external)
        self._changes = tune(changed, values, system, self._libraries, self._facades)
        run.changes = in_order(self._changes, self.order)
        run.n_changes, run.next_change = len(self._changes), 0

    def _begin(self, values: Mapping[str, Value], external: Array) -> None:
        """Make FMUs, start values and memory ready for a new run."""
        if values.keys() != self._settings.names:
            self._attach(self._new_settings(values))
        self._settings.fill(values)
        self._instantiate()
        self._memory.prepare(external)
        self._halted = False
        self._run.done = -1

    def _step(
        self,
        first: int,
        last: int,
        real_time: float | None,
        progress: Callable[[float], object] | None,
    ) -> Result:
        """Step to the last of the points in time, and look up on the way if asked to."""
        if real_time is not None and not 0 < real_time < math.inf:
            raise ExperimentError(f"real_time is {real_time}, expected a positive number")
        self.pace = None if real_time is None else Pace(real_time)
        look = last - first
        if self.pace:
            look = max(1, round(self.pace.interval / self.spec.step))
            self.pace.begin(self.time[first])
        elif progress:
            look = max(1, look // 100)
        for halt in [*range(first + look, last, look), last]:
            if end := self._advance(halt):
                return self._ended(end, first)
            if self.pace:
                self.pace.keep(self.time[halt])
            if progress:
                progress(float(self.time[halt]))
        return self._result(*self._memory.kept(first, last))

    def _advance(self, halt: int) -> Ending | None:
        self._halted = False
        self._run.halt = halt
        outcome = kernel.PAUSED
        while outcome == kernel.PAUSED:  # once a second, so that Ctrl-C is served
            outcome = self._kernel.advance(self._run)
        if outcome == kernel.FAILED:
            name = self.order[self._run.failed]
            facade = self._facades.get(name)
            end = ending(self._run, self._slots[name], facade, self._libraries[name])
            if end is None:
                raise self._failure()
            return end
        if outcome == kernel.HALTED:
            self._halted = True
        return None

    def _ended(self, end: Ending, first: int) -> Result:
        """Return what there is of a run from a step on that an FMU ended.

        In the last row it has its last outputs, and all others have those of the row before. That
        row is left out where the FMU did not come further.
        """
        run = self._run
        name = self.order[run.failed]
        further = end.time > run.start + run.done * run.step
        if further:
            slot = self._slots[name]
            self._memory.append(slot.column, last_outputs(slot))
        if not self._kernel.close_rows(run):
            raise self._failure()
        time, values = self._memory.kept(first, run.done, ended=True)
        if further:
            time = np.append(time[:-1], end.time)
        return self._result(time, values, f"{name}: {end.reason} at t = {end.time:.9g} s")

    def _result(self, time: Array, values: Array, stopped: str | None = None) -> Result:
        names, sums = self._layout.recorded, self._memory.sums
        return Result(time, values, names, self.spec.system, stopped, sums)

    def _place(self, until: float | None) -> int:
        """Return the number of the step that ends at a time."""
        if until is None:
            return len(self.time) - 1
        n = round((until - self.spec.start) / self.spec.step)
        if not 0 < n < len(self.time) or abs(self.time[n] - until) > 1e-9 * self.spec.step * n:
            raise ExperimentError(f"until = {until} s is none of the points in time of the run")
        return n

    def _state_of(self, name: str) -> StateAccess:
        facade = self._facades.get(name)
        instance = facade.c.instance if facade else self._slots[name].instance
        version = self.spec.system.components[name].version
        return StateAccess(name, version, self._libraries[name], instance)

    def _recall(self, name: str, checkpoint: Checkpoint) -> None:
        facade = self._facades.get(name)
        if facade and facade.recall(checkpoint.memory_of(name)) > 1:
            raise SimulationError(f"{name}: {(facade.c.called or b'').decode()} failed on resuming")

    def _identity(self) -> str:
        spec = self.spec
        fmus = ((name, spec.system.components[name]) for name in self.order)
        tokens = [(name, fmu.token, fmu.interface) for name, fmu in fmus]
        signals = list(self._layout.columns), self._layout.summed
        coupling = Coupling.of(spec.coupling)
        return repr((spec.start, spec.step, coupling, spec.constant_step, tokens, signals))

    @property
    def accuracy(self) -> int:
        """The declared order: the coupling's error falls with step^accuracy."""
        return self._coupled.accuracy

    @property
    def effort(self) -> Mapping[str, int]:
        """What the last run took: steps, sweeps through loops or single components, rejected steps.

        Empty where every component does every step once.
        """
        return self._coupled.effort

    def close(self) -> None:
        """Free the FMUs. A closed simulation instantiates them again when it runs."""
        self._halted = False
        self._kernel.forget(self._run)
        for slot in self._slots.values():
            self._kernel.release(slot)
        give_up(self)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_settings"):
            self.close()

    def _new_settings(self, names: Iterable[str]) -> Settings:
        return Settings(self.spec.system, names, self._libraries, self._facades)

    def _attach(self, settings: Settings) -> None:
        self._settings = settings
        for name, slot in self._slots.items():
            settings.attach(name, slot)

    def _instantiate(self) -> None:
        for name, slot in self._slots.items():
            if not slot.instance:
                self._coupled.lose(name)
                fmu = self.spec.system.components[name]
                claim(fmu, name, self)
                arguments = (name, fmu.token, self._libraries[name].resources)
                self._kernel.instantiate(slot, *(text.encode() for text in arguments))
                if not slot.instance:
                    tool = "; it needs the tool that made it" if fmu.needs_tool else ""
                    raise SimulationError(
                        f"{name}: {fmu.path.name} cannot be instantiated{_said(slot)}{tool}"
                    )

    def _failure(self) -> SimulationError:
        run = self._run
        name = self.order[run.failed]
        slot = self._slots[name]
        subject = (
            self._layout.outputs[name][run.output] if run.status == kernel.NOT_FINITE else name
        )
        what = kernel.STATUS.get(run.status, f"returned the unknown status {run.status}")
        facade = self._facades.get(name)
        call = (facade.c.called if facade else None) or run.call
        if run.done < 0:
            when = "during initialisation"
        elif run.done == run.n_steps:
            when = "after the last step"
        else:
            t = run.start + run.done * run.step
            when = f"in the step from t = {t:.9g} s (step {run.done} of {run.n_steps})"
        message = f"{subject}: {call.decode()} {what} {when}{_said(slot)}"
        if run.status == kernel.NOT_SOLVED:
            return SimulationError(f"{self._coupled.unsolved(run.unsolved)}; {when}")
        if run.call.endswith(b"Reset"):
            self._kernel.release(slot)  # the next run instantiates it anew
        return SimulationError(message)


def _said(slot: kernel.Component) -> str:
    message = slot.log.contents.message.decode(errors="replace").strip()
    return f"; the FMU says: {message}" if message else ""
