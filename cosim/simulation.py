"""A prepared system: FMUs instantiated once, run as often as you like."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Self

import numpy as np

from cosim import kernel
from cosim.coupled import Coupled
from cosim.coupling import Coupling, Method
from cosim.ending import ending, kept_rows
from cosim.errors import SimulationError
from cosim.experiment import count_steps
from cosim.kernel.unrolled import unroll
from cosim.layout import Layout
from cosim.library import Library
from cosim.loops import group
from cosim.once import claim, give_up
from cosim.result import Array, Result
from cosim.settings import Settings, check_length
from cosim.signals import Input, sample_inputs
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
    record: tuple[str, ...] | None = None
    coupling: Coupling | Method = "gauss_seidel"
    constant_step: bool = False
    compiled: bool = False

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
    """

    def __init__(self, spec: Specification) -> None:
        system = spec.system
        coupling = Coupling.of(spec.coupling)
        n_steps = count_steps(spec.start, spec.stop, spec.step)
        jacobi = coupling.method == "jacobi"
        groups = group(system, coupling)
        self.spec = spec
        self.time: Array = spec.start + spec.step * np.arange(n_steps + 1, dtype=np.float64)
        self.order = [name for members in groups for name in members.components]
        self._layout = Layout.of(system, spec.record)
        self._libraries = {name: Library(fmu) for name, fmu in system.components.items()}
        self._run, self._facades = wire(
            system, self._layout, self.order, self._libraries, jacobi=jacobi
        )
        self._kernel = kernel.load(unroll(self._run) if spec.compiled else None)
        self._coupled = Coupled(
            system, self._layout, groups, self._libraries, coupling, self._facades
        )
        self._coupled.attach(self._run)
        self._run.constant_step = spec.constant_step
        self._run.n_steps = n_steps
        self._run.start, self._run.stop, self._run.step = spec.start, spec.stop, spec.step
        self._block: Array | None = None  # rows of a block of steps, unless the rows are the record
        if self._run.n_selected < self._run.width:
            self._block = np.empty((self._run.block + 1, self._run.width))
            self._run.rows = self._block.ctypes.data
        self._coupled.attach(self._run)
        self._slots = {name: self._run.components[i] for i, name in enumerate(self.order)}
        self._attach(self._new_settings(system.parameters))
        self._instantiate()

    def run(
        self,
        parameters: Mapping[str, object] | None = None,
        inputs: Mapping[str, Input] | None = None,
    ) -> Result:
        """Run from the start: reset, set start values, initialise, step.

        Parameters
        ----------
        parameters : ``component.variable`` -> start value for this run only
        inputs : exposed input -> array (n_steps + 1,), Signal, function of the time array, or
            number. The value at t[n] holds until t[n + 1]. An input left out keeps the start value
            of its first target

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
        if values.keys() != self._settings.names:
            self._attach(self._new_settings(values))
        self._settings.fill(values)
        self._instantiate()

        run = self._run
        record: Array = np.empty((len(self.time), run.n_selected))
        if self._block is None:
            run.rows = record.ctypes.data
        else:
            run.record = record.ctypes.data
        run.external = external.ctypes.data if external.size else None
        run.done = -1
        outcome = kernel.PAUSED
        while outcome == kernel.PAUSED:  # once a second, so that Ctrl-C is served
            outcome = self._kernel.advance(run)
        if outcome == kernel.FAILED:
            name = self.order[run.failed]
            end = ending(run, self._slots[name], self._facades.get(name), self._libraries[name])
            if end is None:
                raise self._failure()
            rows = record if self._block is None else self._block
            kept = kept_rows(run, record, rows, self._slots[name], end)
            time = np.append(self.time[: run.done + 1], end.time)[: len(kept)]
            stopped = f"{name}: {end.reason} at t = {end.time:.9g} s"
            return Result(time, kept, self._layout.recorded, system, stopped)
        return Result(self.time, record, self._layout.recorded, system)

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
