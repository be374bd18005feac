"""Fills in the kernel's table of components: columns that they read and write, start values."""

from __future__ import annotations

import ctypes
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import lru_cache
from typing import Any, Literal, get_args

from stickslip.cosim import kernel
from stickslip.cosim.assembly.general_path import GeneralComponent, needs_general_path
from stickslip.cosim.assembly.plan import Layout
from stickslip.cosim.component import component_of
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.fmu.instance import batches
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel import structures
from stickslip.cosim.system.scaling import IDENTITY, Scaling, Transform, ValueMap
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
        _transform(slot, scales)
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


def _transform(slot: structures.Component, transforms: Sequence[Transform]) -> None:
    """Let the inputs of a component be scaled or mapped."""
    lines = [t if isinstance(t, Scaling) else IDENTITY for t in transforms]
    if any(line != IDENTITY for line in lines):
        slot.scales = _doubles([s.factor for s in lines] + [s.offset for s in lines])
    if any(isinstance(t, ValueMap) for t in transforms):
        pairs = [t.pairs if isinstance(t, ValueMap) else () for t in transforms]
        slot.maps = (structures.Map * len(pairs))(
            *(structures.Map(len(p), _doubles([x for pair in p for x in pair])) for p in pairs)
        )


def _doubles(numbers: Sequence[float]) -> ctypes.Array[ctypes.c_double]:
    return (ctypes.c_double * len(numbers))(*numbers)


def connected_inputs(
    system: System, layout: Layout, order: Sequence[str], *, jacobi: bool
) -> dict[str, list[tuple[int, str]]]:
    """Return per component its connected inputs with offsets from the row of the present time.

    The kernel sets them in this order.

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
        self._slots = {
            name: next(
                batch
                for batch in self._batches[component_of(name), _phase(variable)]
                if batch.holds(variable)
            )
            for name, variable in self._variables.items()
        }
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
            general.hold(
                {
                    name: (self._variables[name], value)
                    for name, value in values.items()
                    if component_of(name) == component
                }
            )


def _phase(variable: Variable) -> _Phase:
    if variable.causality == "structuralParameter":
        return "structure"
    return "late" if variable.causality == "input" else "early"
