"""The FMUs of a simulation: instantiated, wired into the tables of the kernel, and freed."""

from __future__ import annotations

import ctypes
import logging
from collections.abc import Iterable, Mapping

import numpy as np

from stickslip.cosim import kernel
from stickslip.cosim.assembly.coupled import Coupled
from stickslip.cosim.assembly.plan import Plan
from stickslip.cosim.assembly.wiring import Memory, Room, Settings, wire
from stickslip.cosim.component import Component, component_of
from stickslip.cosim.errors import SimulationError
from stickslip.cosim.fmu.instance import (
    StateAccess,
    claim,
    none_fatal,
    note_fatal,
    release,
    times_fatal,
)
from stickslip.cosim.kernel import structures, unroll
from stickslip.cosim.run import resets
from stickslip.fmi.description.variables import Value
from stickslip.fmi.messages import named

_log = logging.getLogger(__name__)
_N_LAST = 10  # messages in ``Log.last``


class Instances:
    """Makes instances of FMUs, and says which calls on them failed.

    Attributes
    ----------
    slots, libraries : component -> its entry in the table of the kernel, its functions
    general : component -> what it has beside its slot, for those on the general path
    moved : (n,) of the components in their order, whether their outputs moved in the last run
    ready : whether all have an instance
    retries, averages : components that discarded a step and can take it back, and that refused
        derivatives of their inputs; used by `build`
    """

    def __init__(self, plan: Plan, room: Room) -> None:
        self.plan, self._room = plan, room
        self._components = plan.spec.system.components
        self.retries: set[str] = set()
        self.averages: set[str] = set()
        self._epochs: dict[str, int] = {}
        self._warned: set[tuple[str, bytes]] = set()
        try:
            self.build()
        except BaseException:
            if hasattr(self, "_settings"):
                self.free()
            raise

    def build(self) -> None:
        """Wire the components, and make their first instances."""
        plan, spec, system = self.plan, self.plan.spec, self.plan.spec.system
        self.ready = False
        for fmu in {fmu.binary: fmu for fmu in self._components.values()}.values():
            fmu.restore()
        self.libraries = {name: fmu.table() for name, fmu in self._components.items()}
        for name, library in self.libraries.items():
            if library.lacks_reset:
                what = f"it has no function {library.lacks_reset}"
                resets.declare_unresettable(system, [name], what)
        self.run, self.general = wire(
            system,
            plan.layout,
            plan.order,
            self.libraries,
            jacobi=plan.coupling.method == "jacobi",
            tolerance=spec.tolerance,
            retry=self.retries,
        )
        run = self.run
        for general in self.general.values():
            general.c.near = plan.near
        for name in {component_of(target) for target in system.connections}:
            if spec.tolerance is None and (coupled := self.general.get(name)):
                coupled.tighten(plan.n_steps, plan.coupling.adaptive)
        run.n_steps, run.constant_step = plan.n_steps, spec.constant_step
        run.allows_nan = spec.allow_nan
        self.memory = Memory(run, plan, self._room)
        self.kernel = kernel.load(unroll(run) if spec.compiled else None)
        self.slots = {name: run.components[i] for i, name in enumerate(plan.order)}
        for name, general in self.general.items():
            general.bind(self.slots[name], self.kernel)
        self.coupled = Coupled(plan, self.libraries, self.general, self.averages)
        run.start, run.stop, run.step = spec.start, spec.stop, spec.step
        moved = (ctypes.c_uint8 * len(plan.order))()
        self.moved = np.ctypeslib.as_array(moved)
        run.moved, run.began = moved, (ctypes.c_double * run.width)()
        self.coupled.attach(run)
        self._known: dict[frozenset[str], Settings] = {}
        self._attach_settings(system.parameters)
        self._instantiate()

    def begin(self, values: Mapping[str, Value]) -> None:
        """Make sure that all FMUs have an instance, and give them start values for a new run."""
        if values.keys() != self._settings.names:
            self._attach_settings(values)
        self._settings.fill(values)
        self._instantiate()
        self.run.next_change = 0
        self.run.done = -1

    def free(self) -> None:
        """Free all instances; they are made again when a run begins."""
        self.ready = False
        self.drop_invalidated()
        self.kernel.forget(self.run)
        for slot in self.slots.values():
            self.kernel.release(slot)
        release(self)

    def state_of(self, name: str) -> StateAccess:
        """Return access to the state and the values of a component."""
        general = self.general.get(name)
        instance = general.c.instance if general else self.slots[name].instance
        version = self._components[name].version
        return StateAccess(name, version, self.libraries[name], instance, self._mark_fatal)

    def _attach_settings(self, names: Iterable[str]) -> None:
        system, key = self.plan.spec.system, frozenset(names)
        if key not in self._known:
            self._known[key] = Settings(system, names, self.libraries, self.general)
        self._settings = self._known[key]
        for name, slot in self.slots.items():
            self._settings.attach(name, slot)

    def _instantiate(self) -> None:
        """Make sure that all FMUs have an instance; a run that failed may have lost some."""
        self.drop_invalidated()
        if self.ready:
            return
        given = {slot.instance for slot in self.slots.values()}
        for name, slot in self.slots.items():
            if not slot.instance:
                fmu = self._components[name]
                claim(fmu, name, self, self.plan.spec.system.name)
                self._epochs[name] = times_fatal(fmu.binary)
                arguments = (name, fmu.token, self.libraries[name].resources)
                self.kernel.instantiate(slot, *(text.encode() for text in arguments))
                if not slot.instance:
                    tool = "; it says that it needs the tool that made it" if fmu.needs_tool else ""
                    what = f"{fmu.label} cannot be instantiated{_message_of(slot, fmu)}{tool}"
                    raise SimulationError(f"{name}: {what}")
                if slot.instance in given:
                    slot.instance = None
                    what = f"{fmu.label} gives an instance that it has given before"
                    raise SimulationError(f"{name}: {what}; it can serve one component only")
                given.add(slot.instance)
        self.ready = True

    def renew(self, names: Iterable[str]) -> None:
        """Free the used instances of components; the next run has new ones."""
        self.drop_invalidated()
        used = [slot for slot in map(self.slots.__getitem__, names) if slot.used and slot.instance]
        if used:
            self.ready = False
            self.kernel.forget(self.run)
        for slot in used:
            self.kernel.release(slot)

    def drop_invalidated(self) -> None:
        """Let go of instances whose FMU answered fatal, here or elsewhere, without a call."""
        if none_fatal():
            return
        for name, slot in self.slots.items():
            if self._epochs.get(name, 0) < times_fatal(self._components[name].binary):
                self._lose(name, slot)

    def _lose(self, name: str, slot: structures.Component) -> None:
        slot.instance = None
        self.coupled.lose(name)
        if general := self.general.get(name):
            general.lose()
        self.ready = False

    def _mark_fatal(self, name: str) -> None:
        note_fatal(self._components[name].binary)
        self.drop_invalidated()

    def warn(self) -> None:
        """Log the warnings of a run, once for each component and call."""
        for name, slot in self.slots.items():
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

    def failure(self) -> SimulationError:
        """Return the error that says why the kernel came to no end; lets go of what is lost."""
        run = self.run
        name = self.plan.order[run.failed]
        slot = self.slots[name]
        of_output = run.status in {kernel.NOT_FINITE, kernel.RESTORED_WRONGLY}
        subject = self.plan.layout.outputs[name][run.output] if of_output else name
        unknown = f"returned the unknown status {slot.log.contents.unknown}"
        what = kernel.STATUS.get(run.status, unknown)
        general = self.general.get(name)
        call = (general.c.called if general and not of_output else None) or run.call
        if run.done < 0:
            when = "during initialisation"
        elif run.done == run.n_steps:
            when = "after the last step"
        else:
            t = run.start + run.done * run.step
            when = f"in the step from t = {t:.9g} s (step {run.done} of {run.n_steps})"
        message = f"{subject}: {call.decode()} {what} {when}"
        message += _message_of(slot, self._components[name])
        if run.status == kernel.NOT_FINITE:
            message += "; allow_nan (--allow-nan) continues"
        if fault := self.libraries[name].fault:
            self.libraries[name].fault = None
            if not isinstance(fault, Exception):
                raise fault
            raised = f"{self._components[name].label} raised {type(fault).__name__}: {fault}"
            error = SimulationError(f"{name}: {raised} {when}")
            error.__cause__ = fault
            return error
        if run.status == kernel.NOT_SOLVED:
            return SimulationError(f"{self.coupled.unsolved(run.unsolved.contents)}; {when}")
        if run.status == kernel.FATAL:
            self._mark_fatal(name)
        elif run.status == kernel.PENDING and call == b"fmi2DoStep":
            # end a step that goes on by itself, or else leave the instance to it
            instance = general.c.instance if general else slot.instance
            cancel = self.libraries[name].function("fmi2CancelStep")
            if cancel(ctypes.c_void_p(instance)) not in {0, 1}:
                self._lose(name, slot)
        elif run.call.endswith(b"Reset"):
            self.kernel.forget(run)
            self.kernel.release(slot)
        return SimulationError(message)


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
