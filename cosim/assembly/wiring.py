"""Fills in the kernel's table of components: who reads which column, and where outputs go."""

from __future__ import annotations

import ctypes
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache

from stickslip.cosim import kernel
from stickslip.cosim.assembly.general_path import GeneralComponent, needs_general_path
from stickslip.cosim.assembly.layout import Layout
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.kernel import structures
from stickslip.cosim.system.scaling import IDENTITY, Scaling, Transform, ValueMap
from stickslip.cosim.system.system import System

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
    """Return a run that lacks its times, its memory and the instances of the FMUs.

    With it come the components on the general path. ``tolerance`` is the relative one of
    all solvers; where None, each FMU has the one that it proposes. ``retry`` names the
    components whose discarded steps are tried in parts.
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
