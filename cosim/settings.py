"""Start values in the form the kernel takes: one table per component and type."""

from __future__ import annotations

import ctypes
from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from cosim import kernel
from cosim.library import Library
from cosim.names import component_of
from cosim.variables import Value

if TYPE_CHECKING:
    from cosim.system import System


class Settings:
    """Room for a set of start values, laid out once and filled for every run.

    Attributes
    ----------
    names : of the variables, ``component.variable``
    """

    def __init__(
        self, system: System, names: Iterable[str], libraries: Mapping[str, Library]
    ) -> None:
        groups: dict[tuple[str, str], list[str]] = defaultdict(list)
        for name in names:
            groups[component_of(name), system.variable(name).type].append(name)
        self._slots: dict[str, tuple[Any, int]] = {}
        tables: dict[str, list[kernel.Setting]] = defaultdict(list)
        self._keep = tables  # with all that the kernel points to
        for (component, type_name), members in groups.items():
            call, address, c_type = libraries[component].setter(type_name)
            references = (ctypes.c_uint32 * len(members))(
                *(system.variable(name).reference for name in members)
            )
            values = (c_type * len(members))()
            self._slots |= {name: (values, i) for i, name in enumerate(members)}
            room = ctypes.cast(values, ctypes.c_void_p)
            tables[component].append(
                kernel.Setting(address, call.encode(), len(members), references, room)
            )
        self.names = self._slots.keys()
        self._tables = {
            component: (kernel.Setting * len(table))(*table) for component, table in tables.items()
        }

    def attach(self, component: str, slot: kernel.Component) -> None:
        """Let a component of the kernel take its start values from here."""
        table = self._tables.get(component)
        slot.n_settings = 0 if table is None else len(table)
        slot.settings = table

    def fill(self, values: Mapping[str, Value]) -> None:
        """Write values, which were checked, by ``component.variable``."""
        for name, value in values.items():
            room, i = self._slots[name]
            room[i] = value.encode() if isinstance(value, str) else value
