"""A run from its begin to its end, or to the point where it halts."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Collection, Mapping

import numpy as np

from stickslip.cosim import kernel
from stickslip.cosim.assembly.disturbances import disturb
from stickslip.cosim.assembly.external_inputs import sample_ends, sample_inputs
from stickslip.cosim.assembly.input_events import InputEvents, courses, joined
from stickslip.cosim.assembly.tuning import split, tune
from stickslip.cosim.errors import ExperimentError, ParameterError, SimulationError
from stickslip.cosim.fmu.batch import Batch
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.fmu.state import StateAccess
from stickslip.cosim.fmu.values import converted
from stickslip.cosim.kernel import structures
from stickslip.cosim.run.prepared import Prepared
from stickslip.cosim.run.real_time import RealTimePacing
from stickslip.cosim.run.result import Result
from stickslip.cosim.run.termination import last_outputs, terminated
from stickslip.cosim.run.texts import Texts
from stickslip.cosim.signals.scenario import Scenario
from stickslip.cosim.signals.signals import Array, Input, Table
from stickslip.cosim.signals.span import slack
from stickslip.cosim.system.experiment import check_memory
from stickslip.cosim.system.record import Record
from stickslip.fmi.description.variables import Value
from stickslip.fmi.process import check_interruption

_log = logging.getLogger(__name__)
_PER_SIGNAL = 6  # numbers at each point for what a scenario does to a signal, and to make them


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


class Stepping(Prepared):
    """Takes prepared FMUs through a run."""

    def _values(self, parameters: Mapping[str, object]) -> dict[str, Value]:
        """Return the start values of a run, checked."""
        system = self.spec.system
        values = dict(system.parameters)
        for name, value in parameters.items():
            if name not in self._variables:
                self._variables[name] = system.variable(name, ParameterError)
            variable = self._variables[name]
            values[name] = converted(variable, value, name)
            present = system.parameters.get(name, variable.start)
            if variable.causality == "structuralParameter" and values[name] != present:
                raise ParameterError(
                    f"{name} = {values[name]!r} would change the dimensions of arrays; set it in"
                    " the system, before the simulation is prepared"
                )
        return values

    def _set_inputs(
        self, values: Mapping[str, Value], inputs: Mapping[str, Input], scenario: Scenario | None
    ) -> Array:
        """Return the exposed inputs at the points in time; between them they are attached."""
        system, run = self.spec.system, self._run
        external = sample_inputs(system, values, inputs, self.time)
        ends = external
        if scenario or run.coupling:
            ends = sample_ends(system, inputs, self.time, external)
        touched = self._disturb(scenario, external, ends, values)
        free = {name: signal for name, signal in inputs.items() if name not in touched}
        tables = {name: signal for name, signal in free.items() if isinstance(signal, Table)}
        run.n_events = run.event_end = 0
        if tables and not (run.coupling or run.constant_step) and self._varies_step:
            self._events = InputEvents(system, free, tables, self.time, external)
            self._events.attach(run)
        for i, name in enumerate(system.inputs):
            if name in touched:
                tables[name] = joined(self.time, ends[:, i], external[:, i])
        for name, general in self._general_components.items():
            general.follow(courses(system, name, tables))
        self._coupled.follow(ends)
        return external

    def _disturb(
        self, scenario: Scenario | None, external: Array, ends: Array, values: Mapping[str, Value]
    ) -> Collection[str]:
        """Prepare what a scenario does; return the names of the signals that it touches."""
        run, system = self._run, self.spec.system
        self._starts = values
        self._changed: frozenset[str] = frozenset()
        if not (scenario or run.disturbed or run.n_changes):
            return ()
        disturbed = len({name for name, _ in scenario.events}) if scenario else 0
        check_memory(len(self.time), self._kept + _PER_SIGNAL * disturbed)
        tables = scenario.tables(self.time) if scenario else {}
        self._disturbances, changed = split(tables, self._layout, system)
        disturb(self._disturbances, self._layout, run, self._slots, external, ends)
        self._changes = tune(
            changed, values, system, self._libraries, self._general_components, self.order
        )
        run.n_changes = len(self._changes)
        run.changes = (structures.Change * run.n_changes)(*(c for _, c, _ in self._changes))
        self._changed = frozenset(changed)
        return self._disturbances.keys()

    def _begin(self, values: Mapping[str, Value], external: Array, *, apart: bool = False) -> None:
        """Make FMUs, start values and memory, apart for a repetition, ready for a new run."""
        if values.keys() != self._settings.names:
            self._attach(self._new_settings(values))
        self._settings.fill(values)
        self._instantiate()
        self._memory.prepare(external, apart=apart)
        self._run.next_change = 0
        self._halted = False
        self._run.done = -1

    def _step(
        self,
        first: int,
        last: int,
        real_time: RealTimePacing | float | None,
        progress: Callable[[float], object] | None,
    ) -> Result:
        """Step to the last of the points in time, and look up on the way if asked to."""
        self._texts = Texts([])
        self.pacing = None if real_time is None else RealTimePacing.of(real_time)
        look = last - first
        if self.pacing:
            look = max(1, round(self.pacing.interval / self.spec.step))
            self.pacing.begin(self.time[first])
        elif progress:
            look = max(1, look // 100)
        halt = first
        try:
            if self._layout.texts:
                look = 1 if Record.of(self.spec.record).keep == "all" else look
                self._advance(first)
            self._texts = self._new_texts()
            self._texts.note(self.time[first])
            while halt < last:
                halt = min(halt + look, last)
                if end := self._advance(halt):
                    return self._ended(end, first)
                self._texts.note(self.time[halt])
                if self.pacing:
                    self.pacing.keep(self.time[halt])
                if progress:
                    progress(float(self.time[halt]))
        finally:
            self._warn()
        return self._result(*self._memory.kept(first, last))

    def _with_retries(self, attempt: Callable[[], Result]) -> Result:
        """Run; again, and with more care, where an FMU discards a step that it can take back.

        Where a reset fails, the run is done with a new instance.
        """
        while True:
            try:
                return attempt()
            except NotReset as fault:
                self._declare_unresettable([fault.component], str(fault))
            except Discarded as discarded:
                name = discarded.component
                if discarded.derivatives:
                    _log.warning(
                        "%s refuses derivatives of its inputs, though it declares"
                        " canInterpolateInputs: it is given their mean over each step",
                        name,
                    )
                    self._averages.add(name)
                else:
                    _log.info("%s discards steps: they are tried in parts", name)
                    self._retries.add(name)
                self._free()
                self._build()

    def _advance(self, halt: int) -> tuple[float, str] | None:
        self._halted = False
        self._run.halt = halt
        outcome = kernel.PAUSED
        while outcome == kernel.PAUSED:  # once a second, so that Ctrl-C is served
            check_interruption()
            outcome = self._kernel.advance(self._run)
        if outcome == kernel.FAILED:
            self._ready = False
            name = self.order[self._run.failed]
            general = self._general_components.get(name)
            end = terminated(self._run, self._slots[name], general, self._libraries[name])
            if end is None:
                if self._can_take_back(name):
                    raise Discarded(name)
                call = self._run.call
                refuses = call == b"fmi2SetRealInputDerivatives"
                if refuses and self._run.status != kernel.FATAL:
                    raise Discarded(name, derivatives=True)
                error = self._failure()
                raise NotReset(name, str(error)) if call.endswith(b"Reset") else error
            return end
        if outcome == kernel.HALTED:
            self._halted = True
        return None

    def _can_take_back(self, name: str) -> bool:
        """Whether the failure is a step that was discarded and has not been tried in parts."""
        fmu, general = self.spec.system.components[name], self._general_components.get(name)
        call = (general.c.called if general else None) or self._run.call
        able = fmu.interface == "co_simulation" and fmu.restores_state and fmu.varies_step
        discarded = self._run.status == kernel.DISCARD and call.endswith(b"DoStep")
        return able and discarded and name not in self._retries

    def _ended(self, end: tuple[float, str], first: int) -> Result:
        """Return what there is of a run from a step on that an FMU ended.

        In the last row it has its last outputs, and all others have those of the row before. That
        row is left out where the FMU did not come further.
        """
        run = self._run
        name = self.order[run.failed]
        time_reached, reason = end
        further = time_reached > run.start + run.done * run.step
        if further:
            slot = self._slots[name]
            self._memory.append(slot.column, last_outputs(slot))
        if not self._kernel.end_early(run, further):
            raise self._failure()
        time, values = self._memory.kept(first, run.done, ended=True)
        if further:
            time = np.append(time[:-1], time_reached)
        return self._result(time, values, f"{name}: {reason} at t = {time_reached:.9g} s")

    def _state_of(self, name: str) -> StateAccess:
        general = self._general_components.get(name)
        instance = general.c.instance if general else self._slots[name].instance
        version = self.spec.system.components[name].version
        return StateAccess(name, version, self._libraries[name], instance, self._mark_fatal)

    def _new_texts(self) -> Texts:
        """Return what reads the strings to record."""
        names: dict[str, list[str]] = {}
        for name in self._layout.texts:
            names.setdefault(component_of(name), []).append(name)
        return Texts(
            [
                (
                    own,
                    Batch(self._libraries[one], [self.spec.system.variable(n) for n in own], "Get"),
                    self._state_of(one).read,
                )
                for one, own in names.items()
            ]
        )

    def _result(self, time: Array, values: Array, stopped: str | None = None) -> Result:
        names, sums = self._layout.recorded, self._memory.sums
        texts = self._texts.changes
        return Result(time, values, names, self.spec.system, stopped, sums, texts)

    def _place(self, until: float | None) -> int:
        """Return the number of the step that ends at a time."""
        if until is None:
            return len(self.time) - 1
        steps = (until - self.spec.start) / self.spec.step
        n = round(steps) if math.isfinite(steps) else 0
        if not 0 < n < len(self.time) or abs(self.time[n] - until) > slack(until, self.spec.step):
            raise ExperimentError(f"until = {until} s is not a point in time of the run")
        return n
