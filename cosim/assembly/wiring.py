"""The kernel's tables of components and start values, and where it writes the signals of a run."""

from __future__ import annotations

import ctypes
from collections import defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any, Literal, get_args

import numpy as np

from stickslip.cosim import kernel
from stickslip.cosim.assembly.general_path import GeneralComponent, needs_general_path
from stickslip.cosim.assembly.plan import Layout, Plan
from stickslip.cosim.component import component_of
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.fmu.instance import batches
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel import structures
from stickslip.cosim.signals.signals import Array
from stickslip.cosim.system.scaling import IDENTITY
from stickslip.cosim.system.system import System
from stickslip.fmi.description.variables import Value, Variable

# The kernel looks at values and clock once a block: as many steps as stay in the processor's cache.
_BLOCK_STEPS = 256
_BLOCK_VALUES = 2**14


def wire(
    system: System,
    layout: Layout,
    order: Sequence[str],
    libraries: Mapping[str, Library],
    *,
    jacobi: bool,
    tolerance: float | None,
    retry: Collection[str] = (),
) -> tuple[structures.Run, dict[str, GeneralComponent]]:
    """Return a run that lacks its times, memory and instances, and what is on the general path.

    ``tolerance`` is that of all solvers, by default what each FMU proposes. Discarded steps of the
    components in ``retry`` are tried in parts.
    """
    general_components: dict[str, GeneralComponent] = {}
    columns, width = layout.columns, len(layout.columns)
    sources = system.sources()
    inputs = connected_inputs(system, layout, order, jacobi=jacobi)
    components = (structures.Component * len(order))()
    for name, slot in zip(order, components, strict=True):
        fmu = system.components[name]
        slot.version = fmu.version
        slot.call[: len(libraries[name].calls)] = libraries[name].calls
        slot.log = ctypes.pointer(structures.Log())
        if fmu.interface == "co_simulation":
            slot.tolerance = tolerance or fmu.experiment.tolerance or 0.0

        outputs = layout.outputs[name]
        slot.n_linked = layout.linked[name]
        slot.n_outputs = len(outputs)
        slot.output_references = _references(system, outputs)
        slot.column = columns[outputs[0]] if outputs else 0

        offsets = [offset for offset, _ in inputs[name]]
        slot.n_inputs = len(offsets)
        slot.input_references = _references(system, [target for _, target in inputs[name]])
        scales = [system.scaling(sources[target], target) for _, target in inputs[name]]
        scaled = any(scaling != IDENTITY for scaling in scales)
        if scaled:
            both = [s.factor for s in scales] + [s.offset for s in scales]
            slot.scales = (ctypes.c_double * len(both))(*both)
        if not offsets:
            slot.inputs = kernel.NONE
        elif offsets == list(range(offsets[0], offsets[0] + len(offsets))) and not scaled:
            slot.input_offset = offsets[0]
        else:
            slot.inputs = kernel.PAIR if len(offsets) == 2 and not scaled else kernel.SCATTERED
            slot.input_offsets = (ctypes.c_int64 * len(offsets))(*offsets)
            slot.gathered = (ctypes.c_double * len(offsets))()
        read = [system.variable(output) for output in outputs]
        taken = [system.variable(target) for _, target in inputs[name]]
        retries = name in retry
        if isinstance(fmu, Fmu) and (retries or needs_general_path(fmu, [*read, *taken])):
            exchange = fmu.interface == "model_exchange"
            general_components[name] = GeneralComponent(
                fmu,
                libraries[name],
                read,
                taken,
                [exchange and offset >= width for offset in offsets],
                {v.array: system.variable(f"{name}.{v.array}") for v in read + taken if v.array},
                tolerance,
                retries_steps=retries,
            )
            general_components[name].attach_to(slot)
    kinds = {(c.version, c.n_inputs > 0, c.n_outputs > 0) for c in components}
    run = structures.Run(
        components=components,
        n_components=len(order),
        uniform=next((v for v in (2, 3) if kinds == {(v, True, True)}), 0),
        jacobi=jacobi,
        n_external=len(system.inputs),
        width=width,
        block=max(1, min(_BLOCK_STEPS, _BLOCK_VALUES // max(1, width))),
    )
    return run, general_components


def connected_inputs(
    system: System, layout: Layout, order: Sequence[str], *, jacobi: bool
) -> dict[str, list[tuple[int, str]]]:
    """Return per component its inputs, as the kernel sets them, with offsets from the present row.

    What was computed earlier in the same step is read from the next row, and so are the exposed
    inputs of Model Exchange, which takes a straight line from one to the other.
    """
    place = {name: i for i, name in enumerate(order)}
    inputs: dict[str, list[tuple[int, str]]] = defaultdict(list)
    for target, source in system.sources().items():
        component = component_of(target)
        if target in system.connections:
            fresh = not jacobi and place[component_of(source)] < place[component]
        else:  # what is known of the next point in time serves those who look into the step
            fresh = system.components[component].interface == "model_exchange"
        offset = layout.columns[source] + (len(layout.columns) if fresh else 0)
        inputs[component].append((offset, target))
    return defaultdict(list, {component: sorted(found) for component, found in inputs.items()})


def _references(system: System, names: Sequence[str]) -> ctypes.Array[ctypes.c_uint32]:
    return _table(tuple(system.variable(name).reference for name in names))


@lru_cache
def _table(references: tuple[int, ...]) -> ctypes.Array[ctypes.c_uint32]:
    """Return one table for all components with the same references: less memory to step through."""
    return (ctypes.c_uint32 * len(references))(*references)


# When a start value is set: in Configuration Mode, when instantiated, or in Initialization Mode.
_Phase = Literal["structure", "early", "late"]


class Settings:
    """Arrays for a set of start values, allocated once and filled for every run.

    Attributes
    ----------
    names : of the variables, ``component.variable``
    """

    def __init__(
        self,
        system: System,
        names: Iterable[str],
        libraries: Mapping[str, Library],
        general_components: Mapping[str, GeneralComponent],
    ) -> None:
        self._variables = {name: system.variable(name) for name in names}
        self.names = self._variables.keys()
        owners: dict[tuple[str, _Phase], dict[str, Variable]] = defaultdict(dict)
        for name, variable in self._variables.items():
            component = component_of(name)
            owner = system.variable(f"{component}.{variable.owner}")
            owners[component, _phase(variable)][owner.name] = owner
        self._batches = {
            key: batches(libraries[key[0]], variables.values(), "Set")
            for key, variables in owners.items()
        }
        self._general_components = general_components
        self._tables: dict[str, Any] = {}
        self._slots = {}
        for name, variable in self._variables.items():
            found = self._batches[component_of(name), _phase(variable)]
            self._slots[name] = next(batch for batch in found if batch.holds(variable))
        self._numbers = {  # most, and written without detour
            name: (self._slots[name].values, self._slots[name].place(variable))
            for name, variable in self._variables.items()
            if variable.is_signal
        }

    def attach(self, component: str, slot: structures.Component) -> None:
        """Let a component of the kernel take its start values from here."""
        structure, early, late = (self._batches.get((component, p), []) for p in get_args(_Phase))
        if component in self._general_components:
            self._general_components[component].start_with(structure, early, late)
            return
        starts = [*early, *late]
        table = (structures.Setting * len(starts))()
        for setting, batch in zip(table, starts, strict=True):
            setting.set, setting.call = batch.address, batch.call.encode()
            setting.late = batch in late
            setting.n, setting.references = len(batch.references), batch.references
            setting.values = ctypes.cast(batch.values, ctypes.c_void_p)
        self._tables[component] = table
        slot.n_settings, slot.settings = len(starts), table

    def fill(self, values: Mapping[str, Value]) -> None:
        """Write values, which were checked, by ``component.variable``."""
        for name, value in values.items():
            room, place = self._numbers.get(name, (None, 0))
            if room is None:
                self._slots[name].put(self._variables[name], value)
            else:
                room[place] = value
        for component, general in self._general_components.items():
            own = [name for name in values if component_of(name) == component]
            general.hold({name: (self._variables[name], values[name]) for name in own})


def _phase(variable: Variable) -> _Phase:
    if variable.causality == "structuralParameter":
        return "structure"
    return "late" if variable.causality == "input" else "early"


Room = Callable[[tuple[int, int]], Array]
_MOST_APART = 2**23  # numbers of the rows of a repetition


class Memory:
    """Rows of all signals and the record; the kernel uses them as long as this exists.

    The rows of all points in time are the record where all signals of all of them are kept. Else
    there are those of a block of steps, used again for the next. ``room`` makes arrays of a shape.
    """

    def __init__(self, run: structures.Run, plan: Plan, room: Room = np.empty) -> None:
        layout, record = plan.layout, plan.record
        self._run, self._room, self._plan = run, room, plan
        self._keep = record.keep
        self._columns = [layout.columns[name] for name in layout.recorded]
        self._recorded = 0 if layout.whole or record.keep == "last" else len(self._columns)
        self._every = record.every
        self._rows_kept = 3 if record.keep == "range" else plan.n_steps // record.every + 1
        self._record: Array = np.empty((self._rows_kept, 0))
        run.selected = (ctypes.c_int64 * len(self._columns))(*self._columns)
        run.n_selected = self._recorded
        run.every = record.every
        self._whole = layout.whole
        self._rows: Array
        self._block: Array = np.empty((0 if layout.whole else run.block + 1, run.width))
        self._take(self._block, used_again=not layout.whole)

    def prepare(self, external: Array, *, apart: bool = False) -> None:
        """Make room for a run with inputs (n_steps + 1, number); ``apart`` for a repetition."""
        run = self._run
        self._external = external
        run.external = structures.doubles(external) if external.size else None
        room = np.empty if apart else self._room
        if self._whole or (apart and (run.n_steps + 1) * run.width <= _MOST_APART):
            self._rows = self._block  # lets go of those before, whose memory often is the next
            self._take(room((run.n_steps + 1, run.width)), used_again=False)
        elif not run.used_again:
            self._take(self._block, used_again=True)
        if self._recorded:
            self._record = self._block
            self._record = room((self._rows_kept, self._recorded))
            run.record = structures.doubles(self._record)
        run.ranged = 0 if self._keep == "range" else -1
        self._begin = 0

    def prepare_part(self, first: int) -> int:
        """Record all points from a step on instead of their range; return the last with room."""
        run, begin = self._run, -(-first // self._every)
        if run.ranged >= 0:
            self._record = self._room((self._plan.part, self._recorded))
            run.ranged = -1
        self._begin = begin  # the kernel counts from the first point of the run
        place = self._record.ctypes.data - begin * self._recorded * self._record.itemsize
        run.record = ctypes.cast(place, type(run.record))
        if run.done == first == begin * self._every:  # a run that is resumed
            self._record[0] = self.last()
        return (begin + self._plan.part) * self._every - 1

    def prepare_steps(self, inputs: Array) -> None:
        """Make room for steps of which nothing is kept, with the exposed inputs (n,) at first."""
        if not len(self._block):
            self._block = np.empty((self._run.block + 1, self._run.width))
        self._take(self._block, used_again=True)
        self._run.external = self._run.record = None
        self.give(inputs)

    def give(self, inputs: Array) -> None:
        """Let exposed inputs have these values (n,) in the next step, of a run by steps."""
        self._block[:2, : len(inputs)] = inputs  # the present row is one of them

    def last(self) -> Array:
        """Return the signals to record at the end of the last step done."""
        values: Array = self._row(self._run.done)[self._columns]
        return values

    def rows(self) -> Array:
        """Return the rows of all signals up to the last step done; none where they are not kept."""
        return self._rows[: 0 if self._rows is self._block else max(self._run.done + 1, 0)]

    def row(self) -> Array:
        """Return a copy of the signals at the end of the last step done."""
        return self._row(self._run.done).copy()

    def go_on(self, step: int, row: Array) -> None:
        """Let the run go on after a step that left these signals."""
        run = self._run
        if row.shape != (run.width,):
            raise ValueError(f"{row.shape} signals, expected {run.width}")
        run.block_start = run.done = run.closed = step
        self._row(step)[:] = row
        if step % self._every == 0:
            own = row[self._columns[: self._recorded]]
            if self._keep == "range":
                self._record[:], run.ranged = own, 1
            else:
                self._record[step // self._every] = own

    def append(self, first: int, outputs: Array) -> None:
        """Write the row of the next step: the last but for some outputs, from a column on."""
        row = self._row(self._run.done + 1)
        row[:] = self._row(self._run.done)
        row[first : first + len(outputs)] = outputs

    def kept(self, first: int, last: int, *, ended: bool = False) -> tuple[Array, Array, int]:
        """Return time (n,), record (n, signals) and the number of points that these are of.

        They are the points from step first to last; the last one is among them if it ended the run.
        """
        every, further = self._every, ended and last % self._every != 0
        begin, end = -(-first // every), last // every + 1
        points = end - begin + further
        if self._keep == "last":
            return self._plan.at(np.array([float(last)])), self.last()[None], 1
        if self._run.ranged >= 0:
            values = self._record[: 3 * (end - begin)]
            if further:
                values = np.vstack([values, self.last()])
                values = np.array([values.min(0), values.max(0), values[-1]])
            ends = [begin * every if begin < end else last, last if further else (end - 1) * every]
            time = self._plan.at(np.array(ends, dtype=np.float64))[[0, 1, 1][: len(values)]]
            return time, values, points
        if self._keep == "range":
            time = self._plan.at(np.arange(begin * every, last + 1, every, dtype=np.float64))
        else:
            time = self._plan.time[begin * every : last + 1 : every]
        rows = self._rows if self._whole else self._record
        values = rows[begin - self._begin : end - self._begin]
        if further:
            time = np.append(time, self._plan.at(last))
            values = np.vstack([values, self.last()])
        return time, values, points

    def _take(self, rows: Array, *, used_again: bool) -> None:
        self._rows = rows
        self._run.rows, self._run.used_again = structures.doubles(rows), used_again

    def _row(self, step: int) -> Array:
        row: Array = self._rows[step - (self._run.block_start if self._run.used_again else 0)]
        return row
