"""Where each signal lies in a row of the kernel."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase

from stickslip.cosim.errors import ConnectionFault
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.system.record import Deviation, Record
from stickslip.cosim.system.system import System
from stickslip.fmi.messages import suggestion


@dataclass(frozen=True)
class Layout:
    """Columns of a row: exposed inputs, then per component its linked and its other outputs.

    Where the rows are the record, components come in the order of the system, else in one that
    costs least.

    Attributes
    ----------
    columns : name -> column
    outputs : component -> names of its columns, those that other components read first
    linked : component -> how many of its outputs other components read
    recorded : the names to keep: exposed inputs, then by component in the order of the system
    summed : label -> deviation whose squares are summed up
    whole : whether the rows are the record, all signals of all points in time
    texts : the variables of type String to keep, which have no column
    """

    columns: dict[str, int]
    outputs: dict[str, list[str]]
    linked: dict[str, int]
    recorded: list[str]
    summed: dict[str, Deviation]
    whole: bool
    texts: list[str]

    def kept_per_point(self, record: Record) -> float:
        """Return how many numbers of a point in time are kept."""
        if record.keep == "last":
            return 0
        return len(self.columns) if self.whole else len(self.recorded) / record.every

    @classmethod
    def of(cls, system: System, record: Record, turn: Iterable[str] | None = None) -> Layout:
        """Lay out a system of which ``record`` is to be kept.

        Parameters
        ----------
        turn : the components in the order in which they step one after the other; None where all
            inputs are of one point in time
        """
        texts = _texts(system, record.wanted)
        kept = _select(system, record.wanted, texts)
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
        usual = _columns(system, outputs, outputs)
        recorded = sorted(kept, key=usual.__getitem__)
        whole = len(recorded) == len(usual) and record.every == 1 and record.keep == "all"
        columns = usual if whole else _columns(system, outputs, turn or _neighbours(system))
        return cls(columns, outputs, linked, recorded, summed, whole, texts)


def _columns(system: System, outputs: dict[str, list[str]], order: Iterable[str]) -> dict[str, int]:
    names = [*system.inputs, *(name for component in order for name in outputs[component])]
    return {name: column for column, name in enumerate(names)}


def _neighbours(system: System) -> list[str]:
    """Return the components so that the sources of one component are neighbours.

    What lies side by side in a row needs not be gathered. The sources of a component that steps in
    its turn are of two rows: those that step before it are side by side in the order of the steps,
    and the last column of a row is beside the first of the next.
    """
    sources: dict[str, list[str]] = {component: [] for component in system.components}
    for target, source in system.connections.items():
        sources[component_of(target)].append(component_of(source))
    several = (found for found in sources.values() if len(set(found)) > 1)
    first = [component for found in several for component in found]
    return list(dict.fromkeys([*first, *system.components]))


def _texts(system: System, record: Iterable[str] | None) -> list[str]:
    """Return the outputs of type String that fit, and the variables of that type that are named."""
    every = {
        f"{component}.{v.name}": v
        for component, fmu in system.components.items()
        for v in fmu.variables.values()
        if v.type == "String" and not v.dimensions
    }
    usual = [name for name, v in every.items() if v.causality == "output"]
    if record is None:
        return usual
    kept: dict[str, None] = {}
    for wanted in record:
        found = [name for name in usual if fnmatchcase(name, wanted)]
        kept |= dict.fromkeys([wanted] if wanted in every else found)
    return list(kept)


def _select(system: System, record: Iterable[str] | None, texts: Iterable[str]) -> list[str]:
    shown = _of_causality(system, "output") or [
        name
        for name in _of_causality(system, "local")
        if system.variable(name).variability not in {"constant", "fixed"}
    ]
    usual = [*system.inputs, *shown]
    if record is None:
        return usual
    kept: dict[str, None] = {}
    for wanted in record:
        found = [name for name in usual if name == wanted or fnmatchcase(name, wanted)]
        if not found and any(fnmatchcase(name, wanted) for name in texts):
            continue
        if not found and any(mark in wanted for mark in "*?"):
            raise ConnectionFault(
                f"cannot record {wanted!r}: no output fits{suggestion(wanted, usual)}"
            )
        kept |= dict.fromkeys(found or _recordable(system, wanted))
    return list(kept)


def _of_causality(system: System, causality: str) -> list[str]:
    return [
        f"{component}.{element.name}"
        for component, fmu in system.components.items()
        for v in fmu.variables.values()
        if v.causality == causality
        for element in system.variable(f"{component}.{v.name}").elements()
        if element.is_signal
    ]


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
            f"cannot record {name}: it is {variable.type}, expected a number, Boolean or String"
        )
    return [f"{component_of(name)}.{element.name}" for element in elements]
