"""Variables of one type, which one call gets or sets together."""

from __future__ import annotations

import ctypes
from collections import defaultdict
from collections.abc import Iterable
from typing import Any

from stickslip.cosim.fmu.library import Library
from stickslip.cosim.kernel.structures import STORED, Group
from stickslip.fmi.description.variables import Scalar, Value, Variable


class Batch:
    """Room for the values of some variables of one type; arrays lie row by row.

    Attributes
    ----------
    call, address : of the FMI function
    references, values : what it is given
    """

    def __init__(self, library: Library, variables: list[Variable], verb: str) -> None:
        self.call, self.address, self._type = library.accessor(variables[0].type, verb)
        self.discrete = variables[0].is_discrete
        self.clock = variables[0].type == "Clock"
        self.references = (ctypes.c_uint32 * len(variables))(*(v.reference for v in variables))
        self._first: dict[str, int] = {}
        size = 0
        for variable in variables:
            self._first[variable.name] = size
            size += variable.size
        self.values = (self._type * size)()
        binary = variables[0].type == "Binary"
        self._sizes = (ctypes.c_size_t * size)() if binary else None
        for variable in variables:
            if variable.start is not None:
                self.put(variable, variable.start)

    def place(self, variable: Variable) -> int:
        """Return where the values of a variable, or the value of an element, begin."""
        return self._first[variable.owner] + variable.element

    def holds(self, variable: Variable) -> bool:
        """Return whether it has room for a variable, or for the array of an element."""
        return variable.owner in self._first

    def put(self, variable: Variable, value: Value) -> None:
        """Write a value that was checked."""
        first = self.place(variable)
        for i, item in enumerate(value if isinstance(value, tuple) else (value,), first):
            encoded = _encoded(item)
            self.values[i] = encoded
            if self._sizes is not None:
                self._sizes[i] = len(encoded)

    def group(self) -> Group:
        """Return it as the kernel takes it."""
        return Group(
            self.address,
            self.call.encode(),
            [*STORED.values()].index(self._type),
            self.discrete,
            self.clock,
            len(self.references),
            self.references,
            len(self.values),
            ctypes.cast(self.values, ctypes.c_void_p),
            self._sizes,
        )


def batches(library: Library, variables: Iterable[Variable], verb: str) -> list[Batch]:
    """Sort variables, none of them an element, into batches; ``verb`` is Get or Set."""
    members: dict[tuple[str, bool], list[Variable]] = defaultdict(list)
    for variable in variables:
        members[variable.type, variable.is_discrete and verb == "Set"].append(variable)
    return [Batch(library, group, verb) for group in members.values()]


def _encoded(value: Scalar) -> Any:
    return value.encode() if isinstance(value, str) else value
