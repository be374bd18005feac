"""Fills in the kernel's tables for coupling beyond the plain orders."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.ctypeslib import as_array

from stickslip.cosim.assembly.general_path import GeneralComponent
from stickslip.cosim.assembly.plan import Plan
from stickslip.cosim.assembly.wiring import connected_inputs
from stickslip.cosim.component import component_of
from stickslip.cosim.errors import ConnectionFault, ExperimentError
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel import structures as tables
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.system.loops import Group
from stickslip.fmi.description.variables import Variable
from stickslip.fmi.messages import suggestion

_COUNTS = ("n_past", "steps", "sweeps", "rejected", "inner")


class Coupled:
    """What a run needs to agree before the first step and, where it is not plain, in each.

    Components in ``averages`` are given the mean of inputs, whatever they declare.
    """

    def __init__(
        self,
        plan: Plan,
        libraries: Mapping[str, Library],
        general_components: Mapping[str, GeneralComponent],
        averages: Collection[str] = (),
    ) -> None:
        self._system, self._layout, self._coupling = plan.spec.system, plan.layout, plan.coupling
        self._libraries, self._groups = libraries, plan.groups
        self._general_components, self._averages = general_components, averages
        self._names = list(plan.layout.columns)
        self._place = {name: i for i, name in enumerate(plan.order)}
        self._group = {name: g for g in plan.groups for name in g.components}
        jacobi = plan.coupling.method == "jacobi"
        self._inputs = connected_inputs(self._system, plan.layout, plan.order, jacobi=jacobi)
        self._sees = plan.coupling.degree + 1  # the order to which the FMUs follow their inputs
        self._check()

    def attach(self, run: Any) -> None:
        """Let a run, which was wired and has its times, use this."""
        for name, every in self._coupling.every.items():
            if run.n_steps % every:
                what = f"which does not divide the {run.n_steps} steps of the run"
                raise ExperimentError(f"every: {name} steps {every} at a time, {what}")
        self._run = run
        n, connections = len(self._place), self._system.connections
        late = [s for t, s in connections.items() if not self._is_earlier(s, t)]
        if late:
            self._initial = self._loop(0, n, late)
            run.initial = ctypes.pointer(self._initial)
        if self._coupling.is_plain and not any(g.iterated for g in self._groups):
            return
        width = len(self._names)
        adaptive = self._coupling.adaptive
        countable = 16 * math.ulp(max(abs(run.start), abs(run.stop)))  # s; parts of it are, too
        self._members = (tables.Member * n)(
            *(self._member(name, run.components[i]) for name, i in self._place.items())
        )
        self._loops = self._all_loops()
        self._table = tables.Coupling(
            members=self._members,
            n_members=n,
            loops=self._loops,
            n_loops=len(self._loops),
            degree=self._coupling.degree,
            past=(ctypes.c_double * (tables.MAX_PAST * width))(),
            next=(ctypes.c_double * width)(),
            tolerance=adaptive.tolerance if adaptive else 0.0,
            predicted=min(self._coupling.degree, self._sees - 1),
            min_step=max(adaptive.min_step, countable) if adaptive else 0.0,
            nominal=(ctypes.c_double * width)(*map(self._nominal, self._names)),
        )
        run.jacobi = False
        run.coupling = ctypes.pointer(self._table)

    def follow(self, ends: Array | None) -> None:
        """Let the next run have exposed inputs (n, number) at the ends of steps; by steps None."""
        if hasattr(self, "_table"):
            self._ends = ends
            self._table.ends = None if ends is None else tables.doubles(ends)

    def jump(self, inputs: Array) -> None:
        """Let exposed inputs have other values (n,) from now on: no polynomial sees the jump."""
        if hasattr(self, "_table"):
            past = self._places()["past"].reshape(tables.MAX_PAST, -1)[:, : len(inputs)]
            past[:] = inputs + (past - past[0].copy())

    @property
    def effort(self) -> dict[str, int]:
        """Steps tried, passes through loops or single components, and steps taken back."""
        if not hasattr(self, "_table"):
            return {}
        table = self._table
        return {"steps": table.steps, "sweeps": table.sweeps, "rejected": table.rejected}

    def memory(self) -> dict[str, Array]:
        """Return copies of past points, Jacobians and counts, which a saved state needs."""
        if not hasattr(self, "_table"):
            return {}
        memory = {name: place.copy() for name, place in self._places().items()}
        memory["counts"] = np.array([getattr(self._table, name) for name in _COUNTS])
        memory["known"] = np.array([loop.known for loop in self._loops])
        return memory

    def recall(self, memory: Mapping[str, Array]) -> None:
        """Write what ``memory`` returned back."""
        if not hasattr(self, "_table"):
            return
        tables.put_back(self._places(), memory)
        counts = dict(zip(_COUNTS, memory["counts"], strict=True))
        step = counts["inner"]
        if not (0 <= counts["n_past"] <= tables.MAX_PAST and 0 <= step < np.inf):
            raise ValueError(f"{counts['n_past']} past points and a step of {step} s")
        for name, value in counts.items():
            setattr(self._table, name, float(value) if name == "inner" else int(value))
        for loop, known in zip(self._loops, memory["known"], strict=True):
            loop.known = int(known)

    def _places(self) -> dict[str, Array]:
        """Return the kernel's own memory, by name."""
        table, width = self._table, len(self._names)
        rooms = {"past": (table.past, tables.MAX_PAST * width), "next": (table.next, width)}
        rooms |= {f"inverse{i}": (loop.inverse, loop.n**2) for i, loop in enumerate(self._loops)}
        places = {name: as_array(room, (n,)) for name, (room, n) in rooms.items() if n}
        return places | {"times": as_array(table.times)}

    def lose(self, name: str) -> None:
        """Forget the saved state of a component whose instance is gone."""
        if hasattr(self, "_members"):
            self._members[self._place[name]].state = None

    def unsolved(self, loop: Any) -> str:
        """Return which loop was not solved, and what changed most."""
        worst = self._names[loop.columns[loop.worst]]
        members = list(self._place)[loop.first : loop.end]
        variables = {s for s in self._system.connections.values() if component_of(s) in members}
        path = " -> ".join(sorted(variables)) if len(variables) < 9 else ", ".join(members)
        return (
            f"the loop {path} was not solved in {loop.max_iterations} iterations; {worst} changed"
            f" last by {loop.change:.3g}, where {loop.tolerance:g} of its value or nominal value"
            " is allowed; raise Coupling.tolerance, or check that the equations have one solution"
        )

    def _check(self) -> None:
        system, coupling = self._system, self._coupling
        for name in coupling.every:
            if name not in system.components:
                near = suggestion(name, system.components)
                raise ConnectionFault(f"every: {system.name} has no component {name!r}{near}")
        for group in self._groups:
            rates = {coupling.every.get(name, 1) for name in group.components}
            if group.iterated and len(rates) > 1:
                what = f"are iterated together and must step at one rate, got {sorted(rates)}"
                raise ExperimentError(f"{', '.join(group.components)} {what}")
        if not coupling.adaptive:
            return
        for name, fmu in system.components.items():
            if not (fmu.restores_state and fmu.varies_step):
                missing = "GetAndSetFMUstate" if not fmu.restores_state else ""
                missing = missing or "HandleVariableCommunicationStepSize"
                raise ConnectionFault(
                    f"{name} ({fmu.label}) cannot take part in an adaptive step: it does not"
                    f" declare can{missing}; export it with that, or leave the step constant"
                )

    def _is_earlier(self, source: str, target: str) -> bool:
        before = self._place[component_of(source)] < self._place[component_of(target)]
        return before and self._coupling.method != "jacobi"

    def _is_fresh(self, source: str, component: str) -> bool:
        if source in self._system.inputs:  # Model Exchange looks into the step in any case
            exchange = self._system.components[component].interface == "model_exchange"
            return self._coupling.degree > 0 or exchange
        group = self._group[component_of(source)]
        solved = group.iterated and component in group.components
        return solved or self._is_earlier(source, component)

    def _variable(self, name: str) -> Variable:
        """Return an output; of an exposed input the variable that it is like."""
        return self._system.variable(self._system.inputs.get(name, (name,))[0])

    def _nominal(self, name: str) -> float:
        return abs(self._variable(name).nominal or 1.0)

    def _all_loops(self) -> Any:
        loops = []
        for group in self._groups:
            first = self._place[group.components[0]]
            unknown = self._unknowns(group) if group.iterated else []
            loops.append(self._loop(first, first + len(group.components), unknown))
            loops[-1].rollback = bool(unknown) or self._coupling.adaptive is not None
        return (tables.Loop * len(loops))(*loops)

    def _unknowns(self, group: Group) -> list[str]:
        return [
            source
            for target, source in self._system.connections.items()
            if {component_of(source), component_of(target)} <= set(group.components)
            and not self._is_earlier(source, target)
        ]

    def _loop(self, first: int, end: int, sources: Sequence[str]) -> Any:
        unknowns = sorted(set(sources), key=self._layout.columns.__getitem__)
        n = len(unknowns)
        return tables.Loop(
            first=first,
            end=end,
            n=n,
            columns=(ctypes.c_int64 * n)(*(self._layout.columns[name] for name in unknowns)),
            nominal=(ctypes.c_double * n)(*map(self._nominal, unknowns)),
            tolerance=self._coupling.tolerance,
            max_iterations=self._coupling.max_iterations,
            inverse=(ctypes.c_double * (n * n))(),
            work=(ctypes.c_double * (n * n + 6 * n))(),
        )

    def _member(self, name: str, slot: tables.Component) -> Any:
        fmu, n, degree = self._system.components[name], slot.n_inputs, self._coupling.degree
        sources = self._system.sources()
        shown = {self._system.variable(output).owner for output in self._layout.outputs[name]}
        general, exchange = self._general_components.get(name), fmu.interface == "model_exchange"
        takes = fmu.interpolates_inputs and general is None and name not in self._averages
        interpolates = degree > 0 and (exchange or takes)
        links = (tables.Link * n)()
        for link, (_, target) in zip(links, self._inputs[name], strict=True):
            link.column = self._layout.columns[sources[target]]
            link.fresh = self._is_fresh(sources[target], name)
            variable = self._system.variable(target)
            link.holds = variable.is_discrete or self._variable(sources[target]).is_discrete
            through = (fmu.feedthrough.get(output, ()) for output in shown)
            link.feeds_through = any(variable.owner in inputs for inputs in through)
        shows = any(link.feeds_through for link in links)
        member = tables.Member(links=links, values=(ctypes.c_double * n)())
        member.splits = degree > 0 and shows and not interpolates and fmu.varies_step
        if n and not interpolates:
            self._sees = 1 if shows and not member.splits else min(self._sees, 2)
        member.every = self._coupling.every.get(name, 1)
        library = self._libraries[name]
        if self._group[name].iterated or self._coupling.adaptive:
            keeper = general or library
            member.save, member.restore, member.discard = keeper.state_calls()
            member.outputs = (ctypes.c_double * slot.n_outputs)()
            member.again = (ctypes.c_double * slot.n_outputs)()
        if general and exchange:
            fresh = [bool(link.fresh) for link in links]
            member.set_derivatives = general.follow_polynomials(fresh, degree)
        if interpolates:
            references = list(slot.input_references[:n]) * degree
            orders = [order for order in range(1, degree + 1) for _ in range(n)]
            member.interpolates = True
            set_derivatives = "fmi2SetRealInputDerivatives"
            member.set_derivatives = member.set_derivatives or library.address(set_derivatives)
            member.derivative_references = (ctypes.c_uint32 * len(references))(*references)
            member.derivative_orders = (ctypes.c_int32 * len(orders))(*orders)
            member.derivatives = (ctypes.c_double * len(orders))()
        return member
