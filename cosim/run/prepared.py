"""FMUs that are instantiated, wired and ready to run."""

from __future__ import annotations

import ctypes
import logging
from collections.abc import Iterable, Mapping, Sequence
from types import TracebackType
from typing import NoReturn, Self

import numpy as np

from stickslip.cosim import kernel
from stickslip.cosim.assembly.coupled import Coupled
from stickslip.cosim.assembly.general_path import GeneralComponent
from stickslip.cosim.assembly.layout import Layout
from stickslip.cosim.assembly.memory import Memory, Room
from stickslip.cosim.assembly.settings import Settings
from stickslip.cosim.assembly.wiring import library_of, wire
from stickslip.cosim.component import Component
from stickslip.cosim.errors import SimulationError
from stickslip.cosim.fmu import fatal
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.fmu.single_instance import claim, release
from stickslip.cosim.kernel import structures
from stickslip.cosim.kernel.unrolled import unroll
from stickslip.cosim.run import resets
from stickslip.cosim.run.exclusive import Exclusive
from stickslip.cosim.run.real_time import RealTimePacing
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.signals.span import slack
from stickslip.cosim.system.coupling import Coupling
from stickslip.cosim.system.experiment import check_memory, check_tolerance, count_steps
from stickslip.cosim.system.loops import Group, group
from stickslip.cosim.system.record import Record
from stickslip.cosim.system.system import Specification
from stickslip.fmi.description.variables import Variable
from stickslip.fmi.messages import named

_log = logging.getLogger(__name__)
_N_LAST = 10  # messages in ``Log.last``


class Prepared:
    """The FMUs of a simulation, from the first instance to the last call.

    Attributes are those of ``Simulation``.

    Parameters
    ----------
    room : makes arrays of a shape, for what is kept of a run
    """

    def __init__(self, spec: Specification, room: Room = np.empty) -> None:
        self.spec = spec
        self.pacing: RealTimePacing | None = None
        self._room = room
        self._variables: dict[str, Variable] = {}  # those that runs have set
        self._retries: set[str] = set()  # components that discarded a step and can take it back
        self._averages: set[str] = set()  # those that refused derivatives of their inputs
        self._epochs: dict[str, int] = {}
        self._warned: set[tuple[str, bytes]] = set()
        self._exclusive = Exclusive(
            spec.system.name,
            outlives_fork=not any(fmu.needs_tool for fmu in spec.system.components.values()),
        )
        self._build()

    def _plan(self) -> list[Group]:
        """Check the settings, and find times, order and layout; return the groups that iterate."""
        spec, system = self.spec, self.spec.system
        n_steps = count_steps(spec.start, spec.stop, spec.step)
        check_tolerance(spec.tolerance)
        coupling = Coupling.of(spec.coupling)
        groups = group(system, coupling)
        self.order = [name for members in groups for name in members.components]
        turn = None if coupling.method == "jacobi" else self.order
        record = Record.of(spec.record)
        self._layout = layout = Layout.of(system, record, turn)
        self._kept = 1 + len(system.inputs) + layout.kept_per_point(record)
        check_memory(n_steps + 1, self._kept)
        self.time: Array = spec.start + spec.step * np.arange(n_steps + 1, dtype=np.float64)
        return groups

    def _build(self) -> None:
        spec, system, coupling = self.spec, self.spec.system, Coupling.of(self.spec.coupling)
        groups = self._plan()
        self._varies_step = all(fmu.varies_step for fmu in system.components.values())
        self._halted = self._ready = False
        for fmu in {fmu.binary: fmu for fmu in system.components.values()}.values():
            fmu.restore()
        self._libraries = {name: library_of(fmu) for name, fmu in system.components.items()}
        for name, library in self._libraries.items():
            if library.lacks_reset:
                self._declare_unresettable([name], f"it has no function {library.lacks_reset}")
        self._run, self._general_components = wire(
            system,
            self._layout,
            self.order,
            self._libraries,
            jacobi=coupling.method == "jacobi",
            tolerance=spec.tolerance,
            retry=self._retries,
        )
        for general in self._general_components.values():
            general.c.near = slack(max(abs(spec.start), abs(spec.stop)), spec.step)
        for name in {component_of(target) for target in system.connections}:
            if spec.tolerance is None and (coupled := self._general_components.get(name)):
                coupled.tighten(len(self.time) - 1, coupling.adaptive)
        self._run.n_steps, self._run.constant_step = len(self.time) - 1, spec.constant_step
        self._run.allows_nan = spec.allow_nan
        record = Record.of(spec.record)
        self._memory = Memory(self._run, self._layout, record, self.time, self._room)
        self._kernel = kernel.load(unroll(self._run) if spec.compiled else None)
        self._slots = {name: self._run.components[i] for i, name in enumerate(self.order)}
        for name, general in self._general_components.items():
            general.bind(self._slots[name], self._kernel)
        self._coupled = Coupled(
            system,
            self._layout,
            groups,
            self._libraries,
            coupling,
            self._general_components,
            self._averages,
        )
        self._run.start, self._run.stop, self._run.step = spec.start, spec.stop, spec.step
        moved = (ctypes.c_uint8 * len(self.order))()
        self._moved = np.ctypeslib.as_array(moved)
        self._run.moved, self._run.began = moved, (ctypes.c_double * self._run.width)()
        self._coupled.attach(self._run)
        self._attach(self._new_settings(system.parameters))
        self._instantiate()

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
        """Free the FMUs. A closed simulation instantiates them again when it runs.

        Raises
        ------
        SharedSimulation
            When it runs.
        """
        if self._exclusive.is_ours:
            with self._exclusive:
                self._free()

    def _free(self) -> None:
        self._halted = self._ready = False
        self._drop_invalidated()
        self._kernel.forget(self._run)
        for slot in self._slots.values():
            self._kernel.release(slot)
        release(self)

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
        if hasattr(self, "_settings") and self._exclusive.is_ours:
            self._free()

    def __reduce__(self) -> NoReturn:
        raise TypeError(
            f"{self.spec.system.name}: a prepared simulation cannot be pickled or copied, for it"
            " holds instances of FMUs; pickle simulation.spec, and prepare() it where it arrives"
        )

    def _new_settings(self, names: Iterable[str]) -> Settings:
        return Settings(self.spec.system, names, self._libraries, self._general_components)

    def _attach(self, settings: Settings) -> None:
        self._settings = settings
        for name, slot in self._slots.items():
            settings.attach(name, slot)

    def _instantiate(self) -> None:
        """Make sure that all FMUs have an instance; a run that failed may have lost some."""
        self._drop_invalidated()
        if self._ready:
            return
        given = {slot.instance for slot in self._slots.values()}
        for name, slot in self._slots.items():
            if not slot.instance:
                fmu = self.spec.system.components[name]
                claim(fmu, name, self, self.spec.system.name)
                self._epochs[name] = fatal.times(fmu.binary)
                arguments = (name, fmu.token, self._libraries[name].resources)
                self._kernel.instantiate(slot, *(text.encode() for text in arguments))
                if not slot.instance:
                    tool = "; it needs the tool that made it" if fmu.needs_tool else ""
                    raise SimulationError(
                        f"{name}: {fmu.label} cannot be instantiated{_message_of(slot, fmu)}{tool}"
                    )
                if slot.instance in given:
                    slot.instance = None
                    raise SimulationError(
                        f"{name}: {fmu.label} gives an instance that it has given before;"
                        " it can serve one component only"
                    )
                given.add(slot.instance)
        self._ready = True

    def _declare_unresettable(self, names: Sequence[str], what: str) -> None:
        """Note that components cannot be used again after a reset, and what shows it."""
        self._declare(
            names, "cannot be used again after a reset", what, "each run has a new instance of it"
        )

    def _declare_erratic(self, names: Sequence[str], what: str) -> None:
        """Note that new instances of components do not do the same, and what shows it."""
        self._declare(
            names,
            "gives other results in the same run with another new instance",
            what,
            "it cannot be seen whether a reset works, so each run has new instances; if the FMU"
            " keeps something in static variables, each run needs a process of its own"
            " (isolation='process', and close() after each run)",
        )

    def _declare(self, names: Sequence[str], fault: str, what: str, consequence: str) -> None:
        fmus = [self.spec.system.components[name] for name in names]
        each = [f"{name} ({fmu.label})" for name, fmu in zip(names, fmus, strict=True)]
        who = each[0] if len(each) == 1 else f"one of {', '.join(each)}"
        line = f"{who} {fault}: {what}; {consequence}"
        resets.declare([fmu.binary for fmu in fmus], line)

    def _renew(self, names: Iterable[str]) -> None:
        """Free the used instances of components; the next run has new ones."""
        self._drop_invalidated()
        used = [slot for slot in map(self._slots.__getitem__, names) if slot.used and slot.instance]
        if used:
            self._ready = False
            self._kernel.forget(self._run)
        for slot in used:
            self._kernel.release(slot)

    def _drop_invalidated(self) -> None:
        """Let go of instances whose FMU answered fatal, here or elsewhere, without a call."""
        if fatal.none():
            return
        for name, slot in self._slots.items():
            if self._epochs.get(name, 0) < fatal.times(self.spec.system.components[name].binary):
                self._lose(name, slot)

    def _lose(self, name: str, slot: structures.Component) -> None:
        slot.instance = None
        self._coupled.lose(name)
        if general := self._general_components.get(name):
            general.lose()
        self._ready = False

    def _mark_fatal(self, name: str) -> None:
        """Take note that an FMU answered fatal."""
        fatal.declare(self.spec.system.components[name].binary)
        self._drop_invalidated()

    def _warn(self) -> None:
        """Log the warnings of a run, once for each component and call."""
        for name, slot in self._slots.items():
            log = slot.log.contents
            if log.warnings:
                again = (name, log.warned) in self._warned
                self._warned.add((name, log.warned))
                text = log.warning.decode(errors="replace").strip()
                _log.log(
                    logging.DEBUG if again else logging.WARNING,
                    "%s: %s returned warning at t = %.9g s%s (warnings in this run: %d)",
                    name,
                    log.warned.decode(),
                    log.warned_at,
                    f"; the FMU says: {text}" if text else "",
                    log.warnings,
                )
                log.warnings = 0

    def _failure(self) -> SimulationError:
        run = self._run
        name = self.order[run.failed]
        slot = self._slots[name]
        of_output = run.status in {kernel.NOT_FINITE, kernel.RESTORED_WRONGLY}
        subject = self._layout.outputs[name][run.output] if of_output else name
        unknown = f"returned the unknown status {slot.log.contents.unknown}"
        what = kernel.STATUS.get(run.status, unknown)
        general = self._general_components.get(name)
        call = (general.c.called if general and not of_output else None) or run.call
        if run.done < 0:
            when = "during initialisation"
        elif run.done == run.n_steps:
            when = "after the last step"
        else:
            t = run.start + run.done * run.step
            when = f"in the step from t = {t:.9g} s (step {run.done} of {run.n_steps})"
        message = f"{subject}: {call.decode()} {what} {when}"
        message += _message_of(slot, self.spec.system.components[name])
        if run.status == kernel.NOT_FINITE:
            message += "; allow_nan (--allow-nan) continues"
        if fault := self._libraries[name].fault:
            self._libraries[name].fault = None
            if not isinstance(fault, Exception):
                raise fault
            label = self.spec.system.components[name].label
            error = SimulationError(
                f"{name}: {label} raised {type(fault).__name__}: {fault} {when}"
            )
            error.__cause__ = fault
            return error
        if run.status == kernel.NOT_SOLVED:
            return SimulationError(f"{self._coupled.unsolved(run.unsolved.contents)}; {when}")
        if run.status == kernel.FATAL:
            self._mark_fatal(name)
        elif run.status == kernel.PENDING and call == b"fmi2DoStep":
            self._cancel(name, slot, general)
        elif run.call.endswith(b"Reset"):
            self._kernel.forget(run)
            self._kernel.release(slot)
        return SimulationError(message)

    def _cancel(
        self, name: str, slot: structures.Component, general: GeneralComponent | None
    ) -> None:
        """End a step that goes on by itself, or else leave the instance to it."""
        instance = general.c.instance if general else slot.instance
        if self._libraries[name].function("fmi2CancelStep")(ctypes.c_void_p(instance)) not in {
            0,
            1,
        }:
            self._lose(name, slot)


def _message_of(slot: structures.Component, component: Component) -> str:
    """Return the most severe message, and before it the last ones where they are others."""
    log = slot.log.contents
    message = log.message.decode(errors="replace").strip()
    if not message:
        return ""
    place, size = structures.Log.last.offset, structures.Log.last.size // _N_LAST
    ring = ctypes.string_at(ctypes.addressof(log) + place, size * _N_LAST)
    places = (i % _N_LAST for i in range(max(0, log.n_last - _N_LAST), log.n_last))
    texts = (ring[size * i : size * (i + 1)].partition(b"\0")[0] for i in places)
    others = dict.fromkeys(" ".join(t.decode(errors="replace").split()) for t in texts)
    shown = " ".join(message.split())
    before = [text for text in others if text and not shown.startswith(text)]
    last = f"; its last messages: {' | '.join(before)}" if before else ""
    known = ((v.type, v.reference, v.name) for v in component.variables.values())
    said = message + last
    return f"; the FMU says: {named(said, known) if component.version == 2 else said}"
