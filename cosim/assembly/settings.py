"""Start values in the form the kernel takes: one table per component and type."""

from __future__ import annotations

import ctypes
from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any, Literal, get_args

from stickslip.cosim.assembly.general_path import GeneralComponent
from stickslip.cosim.fmu.batch import batches
from stickslip.cosim.fmu.library import Library
from stickslip.cosim.fmu.names import component_of
from stickslip.cosim.kernel import structures
from stickslip.cosim.system.system import System
from stickslip.fmi.description.variables import Value, Variable

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
