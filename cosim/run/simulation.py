"""A prepared system: FMUs instantiated once, run as often as you like."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from stickslip.cosim.assembly.disturbances import held_values, hold_values
from stickslip.cosim.errors import ExperimentError, ParameterError, SimulationError
from stickslip.cosim.fmu.batch import Batch
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.run.checkpoint import Checkpoint, differences
from stickslip.cosim.run.real_time import RealTimePacing
from stickslip.cosim.run.repeated import RESUMED, Repeated
from stickslip.cosim.run.result import Result
from stickslip.cosim.run.termination import last_outputs
from stickslip.cosim.signals.scenario import Scenario
from stickslip.cosim.signals.signals import Table
from stickslip.cosim.signals.tables import Inputs, signals_of
from stickslip.cosim.system.coupling import Coupling
from stickslip.fmi.by_name import by_name


class Simulation(Repeated):
    """Runs a system. Life: ``prepare`` -> any number of ``run`` -> ``close`` (or ``with``).

    One thread at a time; other threads, and forked processes, prepare their own from ``spec``. A
    run leaves the interpreter lock, so their runs go on side by side.

    Attributes
    ----------
    spec : Specification
    time : (n_steps + 1,) float64, s
    order : names of the components as they step
    pacing : how well the last run kept real time, None when it did not have to
    """

    def __repr__(self) -> str:
        spec = self.spec
        return (
            f"Simulation({spec.system!r}, {spec.start:g} to {spec.stop:g} s, step {spec.step:g} s)"
        )

    def run(
        self,
        parameters: Mapping[str, object] | None = None,
        inputs: Inputs | None = None,
        *,
        scenario: Scenario | None = None,
        until: float | None = None,
        real_time: RealTimePacing | float | None = None,
        progress: Callable[[float], object] | None = None,
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
        scenario : what happens to signals on the way
        until : a point of ``time`` (s) to halt at, so that the state can be saved; the stop if
            left out
        real_time : simulated s per s, or a RealTimePacing that also says how often to look at the
            clock; as fast as can be if left out. ``pacing`` tells how well the clock was kept
        progress : is called with the time reached (s) now and then

        Raises
        ------
        ParameterError, SignalError
            Before anything is run.
        SharedSimulation
            When it runs already, in another thread or from its own progress function.
        SimulationError
            When an FMU fails or gives a value that is not finite; the simulation can run again.

        An FMU may ask to end a run: the result is then shorter, and its ``stopped`` says so.
        """
        values = self._values(by_name("parameters", parameters, ParameterError))
        last = self._place(until)
        signals = signals_of(inputs)
        jumps = any(isinstance(signal, Table) for signal in signals.values())
        same_as = None if scenario or jumps else last

        def attempt() -> Result:
            external = self._set_inputs(values, signals, scenario)

            def go(repeated: bool) -> Result:
                return self._step(0, last, real_time, None if repeated else progress)

            repeats = real_time is None
            return self._repeatable(values, external, go, repeats=repeats, same_as=same_as)

        with self._exclusive:
            return self._with_retries(attempt)

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the state that the last run halted in to a file, for ``resume``; return the path.

        Raises
        ------
        SimulationError
            When no run was halted by ``until``, or an FMU cannot give its state away.

        A resumed run equals the uninterrupted one bit for bit, but for Model Exchange: its solver
        is initialised again, so that the two agree within its tolerance.
        """
        with self._exclusive:
            return self._save(Path(path))

    def _save(self, path: Path) -> Path:
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
        memory["/held"] = held_values(self._slots, row[: self._run.width], self._run.done)
        for owner, general in self._general_components.items():
            memory |= {f"{owner}/{name}": values for name, values in general.memory().items()}
        for name, slot in self._slots.items():
            memory[f"{name}/outputs"] = last_outputs(slot)
        starts = {n: float(v) for n, v in self._starts.items() if isinstance(v, int | float)}
        identity, done = self._identity(), self._run.done
        return Checkpoint(identity, done, row, states, starts, memory).write(path)

    def resume(
        self,
        path: str | os.PathLike[str],
        inputs: Inputs | None = None,
        *,
        scenario: Scenario | None = None,
        until: float | None = None,
        real_time: RealTimePacing | float | None = None,
        progress: Callable[[float], object] | None = None,
    ) -> Result:
        """Go on from a saved state; return what follows, the time of the state included.

        Arguments are those of ``run``; start values are in the state.

        Raises
        ------
        SimulationError
            Also when the state is of another system (FMU files, connections, start values), step,
            start, coupling or record; the first differences are named.
        """
        checkpoint = Checkpoint.read(path)
        if difference := differences(checkpoint.identity, self._identity()):
            raise SimulationError(
                f"{path} was saved by another system or run: {difference}; make them equal, or run"
                " from the start"
            )
        last = self._place(until)
        if checkpoint.step < 0:
            raise SimulationError(f"{path}: the saved state is damaged: step {checkpoint.step}")
        if last <= checkpoint.step:
            reached = self.spec.start + checkpoint.step * self.spec.step
            raise ExperimentError(
                f"{path} is at t = {reached:.9g} s already, there is no step left"
            )
        parameters = self.spec.system.parameters
        signals = signals_of(inputs)

        def go(_: bool) -> Result:
            self._advance(0)  # initialised, the FMUs are in a mode that takes a state
            try:
                for name in self.order:
                    self._state_of(name).restore(checkpoint.states[name])
                    self._recall(name, checkpoint)
                self._coupled.recall(checkpoint.memory_of(""))
                self._memory.go_on(checkpoint.step, checkpoint.row)
                hold_values(self._slots, checkpoint.memory["/held"])
            except (KeyError, ValueError, IndexError, TypeError, OverflowError) as fault:
                raise SimulationError(f"{path}: the saved state is damaged: {fault!r}") from fault
            self._compare(path, checkpoint)
            return self._step(checkpoint.step, last, real_time, progress)

        def attempt() -> Result:
            external = self._set_inputs({**parameters, **checkpoint.starts}, signals, scenario)
            result = self._repeatable(parameters, external, go, repeats=False)
            self._traces.add(RESUMED)
            return result

        with self._exclusive:
            return self._with_retries(attempt)

    def learned(self) -> dict[str, float]:
        """Return what the components have learned in the last run.

        Returns
        -------
        ``component.parameter`` -> start value, with which ``run`` of this or another simulation
        goes on from it. FMUs say in an annotation what they learn; others learn nothing.

        Raises
        ------
        SimulationError
            When nothing was run, or an FMU refuses.
        """
        names = {
            f"{name}.{parameter}": f"{name}.{variable}"
            for name, component in self.spec.system.components.items()
            for parameter, variable in component.learned.variables.items()
        }
        return dict(zip(names, self.values(list(names.values())), strict=True))

    def values(self, names: Sequence[str]) -> list[float]:
        """Return the values that numbers and Booleans have at the end of the last run.

        Parameters
        ----------
        names : ``component.variable``, parameters included

        Raises
        ------
        ParameterError
            When there is no such variable, or it is no number.
        SimulationError
            When nothing was run, or an FMU refuses.
        """
        with self._exclusive:
            return [self._value(name) for name in names]

    def _value(self, name: str) -> float:
        variable = self.spec.system.variable(name, ParameterError)
        if variable.type in ("String", "Binary", "Clock") or variable.dimensions:
            raise ParameterError(f"{name} is a {variable.type}, expected a scalar number")
        component = component_of(name)
        slot = self._slots[component]
        if not (slot.used and slot.instance):
            raise SimulationError(f"{name} has no value yet: run first")
        owner = self.spec.system.components[component].variables[variable.owner]
        batch = Batch(self._libraries[component], [owner], "Get")
        self._state_of(component).read(batch)
        return float(batch.values[batch.place(variable)])

    def _compare(self, path: str | os.PathLike[str], checkpoint: Checkpoint) -> None:
        """Check that the FMUs give the outputs again that they gave when their state was saved."""
        for name, slot in self._slots.items():
            now = last_outputs(slot)
            then = checkpoint.memory_of(name).get("outputs", now)
            wrong = ~np.isclose(now, then, rtol=1e-6, atol=1e-9, equal_nan=True)
            if wrong.any():
                place = int(np.argmax(wrong))
                self._ready = False
                raise SimulationError(
                    f"{self._layout.outputs[name][place]}: is {now[place]:.9g} after its FMU took"
                    f" the state from {path}, but was {then[place]:.9g} when that was saved: the"
                    " FMU does not bring back its state, though it declares that it can"
                )

    def _recall(self, name: str, checkpoint: Checkpoint) -> None:
        general = self._general_components.get(name)
        memory = checkpoint.memory_of(name)
        if general and "times" in memory and general.recall(memory) not in {0, 1}:
            raise SimulationError(
                f"{name}: {(general.c.called or b'').decode()} failed on resuming"
            )

    def _identity(self) -> dict[str, str]:
        """Return what must be the same for a saved state to be this simulation's, by what it is."""
        spec, system = self.spec, self.spec.system
        how = {
            "step": float(spec.step),
            "start": float(spec.start),
            "coupling": Coupling.of(spec.coupling),
            "constant_step": spec.constant_step,
            "tolerance": spec.tolerance,
            "order of the components": ", ".join(self.order),
            "signals": ", ".join(self._layout.columns),
            "sums of squares": self._layout.summed,
        }
        fmus = {f"component {name}": fmu.identity for name, fmu in system.components.items()}
        wiring = {
            f"input {target}": f"{source}, {system.scaling(source, target)}"
            for target, source in system.sources().items()
        }
        starts = {f"start value of {name}": value for name, value in system.parameters.items()}
        return {what: str(value) for what, value in {**fmus, **wiring, **starts, **how}.items()}
