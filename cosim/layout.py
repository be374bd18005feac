"""Where each signal lies in a row of the kernel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

from cosim.errors import ConnectionFault
from cosim.names import component_of, suggestion

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
    """

    columns: dict[str, int]
    outputs: dict[str, list[str]]
    linked: dict[str, int]
    recorded: list[str]

    @classmethod
    def of(cls, system: System, record: Sequence[str] | None) -> Layout:
        """Lay out a system of which ``record`` is to be kept.

        Raises
        ------
        ConnectionFault
            When a name or pattern of ``record`` fits nothing.
        """
        kept = _select(system, record)
        outputs: dict[str, list[str]] = {component: [] for component in system.components}
        for source in dict.fromkeys(system.connections.values()):
            outputs[component_of(source)].append(source)
        linked = {component: len(names) for component, names in outputs.items()}
        read = set(system.connections.values())
        for name in kept:
            if name not in system.inputs and name not in read:
                outputs[component_of(name)].append(name)
        names = [*system.inputs, *(name for group in outputs.values() for name in group)]
        columns = {name: column for column, name in enumerate(names)}
        return cls(columns, outputs, linked, sorted(kept, key=columns.__getitem__))


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
