"""Where each signal lies in a row of the kernel."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from cosim.errors import ConnectionFault
from cosim.names import component_of, suggestion
from cosim.record import Deviation, Record

if TYPE_CHECKING:
    from cosim.system import System


@dataclass(frozen=True)
class Layout:
    """Columns of a row: exposed inputs, then per component its linked and its other outputs.

    Attributes
    ----------
    columns : name -> column
    outputs : component -> names of its columns, those that other components read first
    linked : component -> how many of its outputs other components read
    recorded : the names to keep, in the order of their columns
    summed : label -> deviation whose squares are summed up
    """

    columns: dict[str, int]
    outputs: dict[str, list[str]]
    linked: dict[str, int]
    recorded: list[str]
    summed: dict[str, Deviation]

    @classmethod
    def of(cls, system: System, record: Record) -> Layout:
        """Lay out a system of which ``record`` is to be kept.

        Raises
        ------
        ConnectionFault
            When a name or pattern of ``record`` fits nothing.
        """
        kept = _select(system, record.wanted)
        summed = {
            label: _summed(system, label, deviation)
            for label, deviation in record.deviations.items()
        }
        outputs: dict[str, list[str]] = {component: [] for component in system.components}
        for source in dict.fromkeys(system.connections.values()):
            outputs[component_of(source)].append(source)
        linked = {component: len(names) for component, names in outputs.items()}
        read = set(system.connections.values())
        for name in dict.fromkeys([*kept, *(name for d in summed.values() for name in d.names)]):
            if name not in system.inputs and name not in read:
                outputs[component_of(name)].append(name)
        names = [*system.inputs, *(name for group in outputs.values() for name in group)]
        columns = {name: column for column, name in enumerate(names)}
        return cls(columns, outputs, linked, sorted(kept, key=columns.__getitem__), summed)


def _select(system: System, record: Sequence[str] | None) -> list[str]:
    usual = [*system.inputs]
    for component, fmu in system.components.items():
        usual += [
            f"{component}.{element.name}"
            for v in fmu.variables.values()
            if v.causality == "output"
            for element in system.variable(f"{component}.{v.name}").elements()
            if element.is_signal
        ]
    if record is None:
        return usual
    kept: dict[str, None] = {}
    for wanted in record:
        found = [name for name in usual if name == wanted or fnmatchcase(name, wanted)]
        if not found and any(mark in wanted for mark in "*?"):
            raise ConnectionFault(
                f"cannot record {wanted!r}: no output fits{suggestion(wanted, usual)}"
            )
        kept |= dict.fromkeys(found or _recordable(system, wanted))
    return list(kept)


def _summed(system: System, label: str, deviation: Deviation) -> Deviation:
    """Return what is to be summed up, by the names of columns."""
    signal, reference = deviation.signal, deviation.reference
    signal = _scalar(system, label, signal)
    if isinstance(reference, str):
        reference = _scalar(system, label, reference)
        here, there = system.unit_of(signal), system.unit_of(reference)
        if here and there and not here.same_as(there):
            raise ConnectionFault(
                f"cannot sum up {label!r}: {signal} is in {here.name!r}, {reference} in"
                f" {there.name!r}"
            )
    elif not math.isfinite(reference):
        raise ConnectionFault(f"cannot sum up {label!r}: the reference {reference} is not finite")
    return replace(deviation, signal=signal, reference=reference)


def _scalar(system: System, label: str, name: str) -> str:
    found = [name] if name in system.inputs else _recordable(system, name)
    if len(found) > 1:
        raise ConnectionFault(
            f"cannot sum up {label!r}: {name} is an array; name one of its elements: {found[0]}"
        )
    return found[0]


def _recordable(system: System, name: str) -> list[str]:
    try:
        variable = system.variable(name)
    except ConnectionFault as fault:
        raise ConnectionFault(f"cannot record {name}: {fault}") from None
    elements = [element for element in variable.elements() if element.is_signal]
    if not elements:
        raise ConnectionFault(
            f"cannot record {name}: it is {variable.type}, expected a number or Boolean"
        )
    return [f"{component_of(name)}.{element.name}" for element in elements]
