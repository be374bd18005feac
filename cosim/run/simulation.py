"""A prepared system: FMUs instantiated once, run as often as you like."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import NoReturn, Self, TypeVar

import numpy as np

from stickslip.cosim.assembly.plan import Plan
from stickslip.cosim.assembly.wiring import Room
from stickslip.cosim.component import component_of
from stickslip.cosim.errors import ExperimentError, ParameterError, SimulationError
from stickslip.cosim.fmu.instance import Batch
from stickslip.cosim.run import resets
from stickslip.cosim.run.checkpoint import Checkpoint, differences, identity, put_back, taken
from stickslip.cosim.run.guards import Exclusive
from stickslip.cosim.run.instances import Instances
from stickslip.cosim.run.result import Result, Take, taking
from stickslip.cosim.run.reuse import Reuse
from stickslip.cosim.run.stepping import Discarded, NotReset, Stepper
from stickslip.cosim.signals.signals import Array, Table
from stickslip.cosim.signals.tables import Inputs, signals_of
from stickslip.cosim.system.system import Specification
from stickslip.fmi.by_name import by_name

T = TypeVar("T")
_log = logging.getLogger(__name__)


class Simulation:
    """Runs a system. Life: ``prepare`` -> any number of ``run`` -> ``close`` (or ``with``).

    In place of ``run``, ``start`` and then ``step`` as often as needed lead through a run by steps.

    One thread at a time; other threads, and forked processes, prepare their own from ``spec``. A
    run leaves the interpreter lock, so their runs go on side by side.

    Attributes
    ----------
    spec : Specification
    """

    def __init__(self, spec: Specification, room: Room = np.empty) -> None:
        self.spec = spec
        tools = any(fmu.needs_tool for fmu in spec.system.components.values())
        self._exclusive = Exclusive(spec.system.name, outlives_fork=not tools)
        self._plan = Plan(spec)
        self._fmus = Instances(self._plan, room)
        self._stepper = Stepper(self._fmus)
        self._reuse = Reuse(self._stepper)

    @property
    def time(self) -> Array:
        """The points in time, (n_steps + 1,) s."""
        return self._plan.time

    @property
    def order(self) -> list[str]:
        """Names of the components as they step."""
        return self._plan.order

    @property
    def effort(self) -> Mapping[str, int]:
        """What the last run took: steps, sweeps through loops or single components, rejected steps.

        Empty where every component does every step once.
        """
        return self._fmus.coupled.effort

    def before_repetition(self, call: Callable[[], object]) -> None:
        """Let something be called before a run is repeated to see what a reset does."""
        self._reuse.before_repetition = call

    def __repr__(self) -> str:
        s = self.spec
        return f"Simulation({s.system!r}, {s.start:g} to {s.stop:g} s, step {s.step:g} s)"

    def run(
        self,
        parameters: Mapping[str, object] | None = None,
        inputs: Inputs | None = None,
        *,
        tunable: Inputs | None = None,
        until: float | None = None,
        progress: Callable[[float], object] | None = None,
        out: str | os.PathLike[str] | Take | None = None,
    ) -> Result:
        """Run from the start: reset, set start values, initialise, step.

        The result is that of new instances. The second run is done twice to see whether a reset
        achieves this; where it does not, each run has new instances of that FMU, and a warning is
        logged once.

        Parameters
        ----------
        parameters : ``component.variable`` -> start value for this run only
        inputs : exposed input -> array (n_steps + 1,), Signal, function of time [s], series
            of pandas over time [s], or number; or a data frame with a column of each. The value at
            t[n] holds until t[n + 1], or until a Table jumps; Model Exchange follows the lines of a
            Table. An input left out keeps the start value of its first target
        tunable : tunable parameter -> value over time, as of an input. It changes at a point in
            time, before the step from there; where an FMU knows events, by one
        until : a point of ``time`` (s) to halt at, so that the state can be saved; the stop if
            left out
        progress : is called with the time reached (s) now and then
        out : FILE.csv for all points, or a function that is called with parts of the result, each a
            Result whose values the next one overwrites. With ``Record(keep="range")`` this is done
            as the run goes, which then needs no memory for the points. A run that has to begin
            again starts the file again, or gives the first part again

        Raises
        ------
        ParameterError, SignalError : Before anything is run
        SharedSimulation : when it runs already, in another thread or from its own progress function
        SimulationError : when an FMU fails or gives a value that is not finite; the simulation can
            run again

        An FMU may ask to end a run: the result is then shorter, and its ``stopped`` says so.
        """
        values = self._plan.start_values(by_name("parameters", parameters, ParameterError))
        last = self._plan.step_at(until)
        signals = signals_of(inputs)
        jumps = any(isinstance(signal, Table) for signal in signals.values())
        changes = signals_of(tunable)
        same_as = None if changes or jumps else (last, out is None)

        def attempt(take: Take | None) -> Result:
            def go(repeated: bool) -> Result:
                return self._go(0, last, *(() if repeated else (progress, take)))

            external = self._stepper.follow(values, signals, changes)
            return self._reuse.run(values, external, go, same_as=same_as)

        with self._exclusive, taking(out) as take:
            return self._with_retries(lambda: attempt(take))

    def _go(
        self,
        first: int,
        last: int,
        progress: Callable[[float], object] | None = None,
        take: Take | None = None,
    ) -> Result:
        """Step from the first to the last of the points in time, and hand the result on."""
        if take is None or self._plan.record.keep != "range":
            result = self._stepper.go(first, last, progress)
            if take:
                take(result)
            return result
        kept: Result | None = None

        def add(part: Result) -> Result:
            nonlocal kept
            take(part)
            kept = part.range(kept)
            return kept

        return add(self._stepper.go(first, last, progress, add))

    def start(
        self,
        parameters: Mapping[str, object] | None = None,
        inputs: Mapping[str, float] | None = None,
    ) -> dict[str, float]:
        """Begin a run by steps: reset, set start values and inputs, initialise.

        Parameters and errors are those of ``run``; an input left out has the start value of its
        first target. Returns name -> value at the start, of the signals to record but for exposed
        inputs.
        """
        values = self._plan.start_values(by_name("parameters", parameters, ParameterError))

        def attempt() -> dict[str, float]:
            self._reuse.renew(values)
            return self._stepper.start(values, inputs or {})

        with self._exclusive:
            return self._with_retries(attempt)

    def step(self, inputs: Mapping[str, float] | None = None) -> dict[str, float]:
        """Do one communication step of a run that ``start`` has begun.

        Nothing of it is kept, so that ``stop`` may be far away with ``Record(keep="last")``. The
        results are those of a whole run, bit for bit, whose inputs hold over each step. An input
        left out keeps the value it has. Returns name -> value at the end of the step, as ``start``
        does.

        Raises
        ------
        ExperimentError : the run is at its stop
        SignalError : there is no such input, or it cannot have such a value; the run can go on
        SimulationError : ``start`` was not called, or an FMU fails or asks to end the run
        """
        with self._exclusive:
            try:
                return self._stepper.step(inputs or {})
            except Discarded as discarded:
                self._heed(discarded)
                what = "discarded a step; begin the run again with start()"
                advice = "its steps are then tried in parts, or without derivatives of its inputs"
                raise SimulationError(f"{discarded.component} {what}: {advice}") from None

    def _with_retries(self, attempt: Callable[[], T]) -> T:
        """Run; again, with more care or new instances, where a discarded step or a reset allows."""
        while True:
            try:
                return attempt()
            except NotReset as fault:
                resets.declare_unresettable(self.spec.system, [fault.component], str(fault))
            except Discarded as discarded:
                self._heed(discarded)

    def _heed(self, discarded: Discarded) -> None:
        """Let a component be stepped with more care from now on."""
        name = discarded.component
        if discarded.derivatives:
            _log.warning(
                "%s refuses derivatives of its inputs, though it declares canInterpolateInputs: it"
                " is given their mean over each step",
                name,
            )
            self._fmus.averages.add(name)
        else:
            _log.info("%s discards steps: they are tried in parts", name)
            self._fmus.retries.add(name)
        self._reuse.free()
        self._fmus.build()

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the state that the last run halted in to a file, for ``resume``; return the path.

        A resumed run equals the uninterrupted one bit for bit, but for Model Exchange: its solver
        is initialised again, so that the two agree within its tolerance. It is a SimulationError
        when no run was halted by ``until``, or an FMU cannot give its state away.
        """
        with self._exclusive:
            if not self._stepper.halted:
                raise SimulationError("there is no state to save: halt a run with run(until=...)")
            return taken(self._stepper).write(path)

    def resume(
        self,
        path: str | os.PathLike[str],
        inputs: Inputs | None = None,
        *,
        tunable: Inputs | None = None,
        until: float | None = None,
        progress: Callable[[float], object] | None = None,
        out: str | os.PathLike[str] | Take | None = None,
    ) -> Result:
        """Go on from a saved state; return what follows, the time of the state included.

        Arguments are those of ``run``; start values are in the state.

        Raises
        ------
        SimulationError : Also when the state is of another system (FMU files, connections, start
            values), step, start, coupling or record; the first differences are named
        """
        checkpoint = Checkpoint.read(path)
        if difference := differences(checkpoint.identity, identity(self._plan)):
            what = f"{difference}; make them equal, or run from the start"
            raise SimulationError(f"{path} was saved by another system or run: {what}")
        last = self._plan.step_at(until)
        if checkpoint.step < 0:
            raise SimulationError(f"{path}: the saved state is damaged: step {checkpoint.step}")
        if last <= checkpoint.step:
            reached = self.spec.start + checkpoint.step * self.spec.step
            when = f"t = {reached:.9g} s already"
            raise ExperimentError(f"{path} is at {when}, there is no step left")
        parameters = self.spec.system.parameters
        signals, changes = signals_of(inputs), signals_of(tunable)

        def attempt(take: Take | None) -> Result:
            def go(_: bool) -> Result:
                put_back(self._stepper, checkpoint, path)
                return self._go(checkpoint.step, last, progress, take)

            external = self._stepper.follow({**parameters, **checkpoint.starts}, signals, changes)
            return self._reuse.run(parameters, external, go, resumed=True)

        with self._exclusive, taking(out) as take:
            return self._with_retries(lambda: attempt(take))

    def learned(self) -> dict[str, float]:
        """Return what the components have learned in the last run: parameter -> start value.

        With these ``run`` of this or another simulation goes on from it. FMUs say in an annotation
        what they learn; others learn nothing. The errors are those of `values`.
        """
        names = {
            f"{name}.{parameter}": f"{name}.{variable}"
            for name, component in self.spec.system.components.items()
            for parameter, variable in component.learned.variables.items()
        }
        return dict(zip(names, self.values(list(names.values())), strict=True))

    def values(self, names: Sequence[str]) -> list[float]:
        """Return the values that variables, parameters included, have at the end of the last run.

        Raises
        ------
        ParameterError : there is no such variable, or it is no number
        SimulationError : nothing was run, or an FMU refuses
        """
        with self._exclusive:
            return [self._value(name) for name in names]

    def close(self) -> None:
        """Free the FMUs, unless it runs (SharedSimulation); another run instantiates them again."""
        if self._exclusive.is_ours:
            with self._exclusive:
                self._reuse.free()
                self._stepper.halted = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        self.close()

    def __del__(self) -> None:
        if hasattr(self, "_reuse") and self._exclusive.is_ours:
            self._reuse.free()

    def __reduce__(self) -> NoReturn:
        what = "a prepared simulation cannot be pickled or copied, for it holds instances of FMUs"
        advice = "pickle simulation.spec, and prepare() it where it arrives"
        raise TypeError(f"{self.spec.system.name}: {what}; {advice}")

    def _value(self, name: str) -> float:
        variable = self.spec.system.variable(name, ParameterError)
        if variable.type in ("String", "Binary", "Clock") or variable.dimensions:
            raise ParameterError(f"{name} is a {variable.type}, expected a scalar number")
        component = component_of(name)
        slot = self._fmus.slots[component]
        if not (slot.used and slot.instance):
            raise SimulationError(f"{name} has no value yet: run first")
        owner = self.spec.system.components[component].variables[variable.owner]
        batch = Batch(self._fmus.libraries[component], [owner], "Get")
        self._fmus.state_of(component).read(batch)
        return float(batch.values[batch.place(variable)])
