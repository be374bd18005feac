"""A simulation whose FMUs run in a child process."""

import inspect
import os
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any
from weakref import finalize

import numpy as np

from stickslip.cosim.assembly.plan import Plan
from stickslip.cosim.errors import FmuCrashed, ParameterError
from stickslip.cosim.isolation.messages import Reply, called, portable_inputs
from stickslip.cosim.isolation.process import Process
from stickslip.cosim.run import resets
from stickslip.cosim.run.guards import Exclusive
from stickslip.cosim.run.result import Result, taking
from stickslip.cosim.run.simulation import Simulation
from stickslip.cosim.signals.signals import Input
from stickslip.cosim.signals.tables import signals_of
from stickslip.cosim.system.settings import Isolation
from stickslip.cosim.system.system import Specification
from stickslip.fmi.by_name import by_name
from stickslip.fmi.files import atomic_write

_BIND_RUN = inspect.signature(Simulation.run).bind
_BIND_RESUME = inspect.signature(Simulation.resume).bind


class IsolatedSimulation(Simulation):
    """Runs a system in a child process: a simulation like any other, at nearly its speed.

    A crash, an exit or a hang of the child becomes FmuCrashed, which names component, call and time
    and shows what was printed; the next run starts another child.
    """

    def __init__(self, spec: Specification, limits: Isolation) -> None:
        self.spec, self._limits = spec, limits
        self._plan = Plan(spec)
        self._effort = dict[str, int]()
        self._process: Process | None = None
        self._state_path = ""  # of the state to resume from
        self._used_again = False  # whether a child has done a second run
        self._exclusive = Exclusive(spec.system.name, outlives_fork=False)
        self._living()

    @property
    def effort(self) -> Mapping[str, int]:
        """What the last run took, see Simulation."""
        return self._effort

    def run(self, *arguments: Any, **named: Any) -> Result:
        """Run from the start, see Simulation; starts a child where there is none."""
        return self._run_there("run", _BIND_RUN(self, *arguments, **named))

    def resume(self, *arguments: Any, **named: Any) -> Result:
        """Continue from a saved state, see Simulation; the errors are those of ``run``."""
        return self._run_there("resume", _BIND_RESUME(self, *arguments, **named))

    def start(
        self,
        parameters: Mapping[str, object] | None = None,
        inputs: Mapping[str, float] | None = None,
    ) -> dict[str, float]:
        """Begin a run by steps, see Simulation; starts a child where there is none."""
        starts = by_name("parameters", parameters, ParameterError)
        with self._exclusive:
            arguments = {"method": "start", "arguments": (starts, _numbers(inputs))}
            return dict(self._first_or_again(lambda: self._ask("ask", arguments))["result"])

    def step(self, inputs: Mapping[str, float] | None = None) -> dict[str, float]:
        """Do one step of a run that ``start`` has begun, see Simulation."""
        with self._exclusive:
            arguments = {"method": "step", "arguments": (_numbers(inputs),)}
            return dict(self._ask("ask", arguments)["result"])

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the state that the last run halted in to a file, see Simulation."""
        with self._exclusive:
            state = self._living().state
            self._ask("save", {"path": str(state)})
            return atomic_write(Path(path), state.read_bytes())

    def values(self, names: Sequence[str]) -> list[float]:
        """Return the values that variables have at the end of the last run, see Simulation."""
        with self._exclusive:
            reply = self._ask("ask", {"method": "values", "arguments": (list(names),)})
            return [float(value) for value in reply["result"]]

    def close(self) -> None:
        """Free the FMUs and end the child. A closed simulation starts another when it runs."""
        process = self._process
        if process is None or not self._exclusive.is_ours:
            return
        with self._exclusive:
            try:
                self._ask("close")
                process.leave()
            finally:
                self._give_up()

    def __exit__(self, kind: object, error: object, traceback: object) -> None:
        try:
            self.close()
        except FmuCrashed:
            if error is None:
                raise

    def _run_there(self, how: str, bound: inspect.BoundArguments) -> Result:
        bound.apply_defaults()
        arguments = bound.arguments
        del arguments["self"]
        progress = arguments["progress"]
        inputs, tunable = (signals_of(arguments[name]) for name in ("inputs", "tunable"))
        if how == "resume":
            self._state_path = str(Path(arguments["path"]).absolute())
        else:
            starts = by_name("parameters", arguments["parameters"], ParameterError)
            arguments["parameters"] = starts
        arguments |= {
            "inputs": portable_inputs(inputs, lambda: self.time),
            "tunable": portable_inputs(tunable, lambda: self.time),
            "progress": progress is not None,
            "how": how,
        }
        with self._exclusive, taking(arguments.pop("out")) as take:
            arguments["parts"] = take is not None and self._plan.record.keep == "range"

            def hand(part: Reply) -> None:
                if take:
                    take(self._result_of(part))

            ask = partial(self._ask_to_run, arguments, progress, hand)
            reply = self._first_or_again(ask)
            self._effort = reply["effort"]
            result = self._result_of(reply)
            if take and not arguments["parts"]:
                take(result)
            return result

    def _first_or_again(self, ask: Callable[[], Reply]) -> Reply:
        """Ask for a run; where the FMUs do not bear to be used again, in another child."""
        binaries = {fmu.binary for fmu in self.spec.system.components.values()}
        if self._process and self._process.runs and binaries & resets.crashed:
            self._give_up()
        process = self._living()
        try:
            reply = ask()
        except FmuCrashed as crash:
            if not self._ended_by_reuse(process, crash):
                raise
            reply = ask()
        self._used_again |= process is self._process and process.runs > 0
        self._living().runs += 1
        return reply

    def _ask_to_run(self, arguments: dict[str, Any], *how: Any) -> Reply:
        if arguments["how"] == "resume":  # where the child may read
            arguments["path"] = str(self._living().state)
            with suppress(OSError):  # the child says that there is none
                atomic_write(self._living().state, Path(self._state_path).read_bytes())
        return self._ask("run", arguments, *how)

    def _ended_by_reuse(self, process: Process, crash: FmuCrashed) -> bool:
        """Whether the crash comes from using instances again, so that a new child avoids it."""
        mark, components = process.shared.mark, self.spec.system.components
        name = called(mark, self.order)
        names = [name] if name else self.order
        if process.repeats:
            resets.declare_unresettable(self.spec.system, names, str(crash))
        binaries = {components[name].binary for name in names}
        second = process.runs > 0 and not self._used_again
        reused = process.repeats or second or mark.call.endswith((b"Reset", b"FreeInstance"))
        if reused:
            resets.crashed.update(binaries)
        return reused

    def _result_of(self, reply: Reply) -> Result:
        """Copy a result from the shared memory, which the next run overwrites."""
        n, width = reply["shape"]
        time = np.array(reply["times"])
        if n > len(time):
            first, every = self._plan.step_near(time[0]), self._plan.record.every
            steps = np.arange(first, first + n * every, every, dtype=np.float64)
            time = np.append(self._plan.at(steps[:-1]), time[-1])  # where an FMU has ended the run
        values = self._living().shared.numbers[: n * width].reshape(n, width).copy()
        layout, kept = self._plan.layout, (reply["stopped"], reply["texts"], reply["points"])
        names, system = layout.recorded, self.spec.system
        return Result(time, values, names, system, *kept, places=layout.places)

    def _ask(
        self, what: str, arguments: Mapping[str, object] = MappingProxyType({}), *how: Any
    ) -> Reply:
        process = self._living()
        process.stands_for = self._state_path
        try:
            reply = process.ask(what, dict(arguments), *how)
        except BaseException:  # also Ctrl-C: the child is in the middle of something
            self._give_up()
            raise
        return process.told(reply)

    def _living(self) -> Process:
        """Return the child; start one and prepare the simulation in it where there is none."""
        if self._process is None:
            n = self._plan.rows * len(self._plan.layout.recorded)
            components = self.spec.system.components.values()
            solver = any(fmu.interface == "model_exchange" for fmu in components)
            modules = ("fmpy.sundials.libraries",) if solver else ()
            self._process = Process(self.spec, self._limits, self.order, n, modules)
            self._end = finalize(self, self._process.end)
            try:
                self._ask("prepare")
            except BaseException:
                self._give_up()
                raise
        return self._process

    def _give_up(self) -> None:
        self._process = None
        self._end()


def _numbers(inputs: Mapping[str, float] | None) -> dict[str, Input]:
    return portable_inputs(inputs or {}, lambda: np.zeros(1))
