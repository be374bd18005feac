"""The table that a log's file holds, before its columns have roles."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from stickslip.errors import RecordingError, UsageError
from stickslip.fmi.messages import suggestion
from stickslip.logs.description import Product
from stickslip.logs.finding import Finding
from stickslip.servo.measurement import Array


@dataclass(frozen=True, eq=False)
class LogTable:
    """Columns by name, as they were read."""

    path: str  # of the file, for messages
    names: tuple[str, ...]  # of all columns, in the file's order
    numbers: Mapping[str, Array]  # (n,) by name; nan where a field is empty
    # (n,) by name, of columns that hold no numbers
    texts: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)  # by name, where the file states one
    faults: Mapping[str, str] = field(default_factory=dict)  # by name, why a column cannot be used
    scalars: Mapping[str, float] = field(default_factory=dict)  # single numbers beside the columns
    # (n,) number of the line or row of each value; None counts from 1
    rows: NDArray[np.intp] | None = None
    headed: bool = True  # whether the file itself names its columns
    findings: tuple[Finding, ...] = ()  # of reading

    def row(self, k: int) -> int:
        """Return the number in the file of the k-th value."""
        return k + 1 if self.rows is None else int(self.rows[k])

    def part(self, rows: NDArray[np.intp]) -> LogTable:
        """Return a table without columns that has some rows (k,) of this one."""
        numbers = np.array([self.row(int(k)) for k in rows], dtype=np.intp)
        return LogTable(self.path, self.names, {}, scalars=self.scalars, rows=numbers)

    def find(self, key: str | int, role: str) -> str:
        """Return the name of the column with a name or a number from 1.

        Raises RecordingError when there is none, or several only differ in case.
        """
        if isinstance(key, str) and key in self.names:
            return key
        if isinstance(key, int) or key.isdecimal():
            if 1 <= int(key) <= len(self.names):
                return self.names[int(key) - 1]
            raise RecordingError(
                f"{self.path}: {role}: no column {key}, there are {len(self.names)}"
            )
        alike = [name for name in self.names if name.lower() == key.lower()]
        if len(alike) == 1:
            return alike[0]
        if alike:
            raise RecordingError(f"{self.path}: {role}: which column, {' or '.join(alike)}?")
        raise RecordingError(f"{self.path}: {role}: no column '{key}'{suggestion(key, self.names)}")

    def value(self, product: Product, what: str) -> float:
        """Return the value of a product, whose factors may name scalars of the file.

        Raises UsageError when a factor is neither number nor name, or the value is not finite.
        """
        value = 1.0
        for factor in str(product).split("*"):
            name = factor.strip()
            try:
                value *= self.scalars[name] if name in self.scalars else float(name)
            except ValueError:
                raise UsageError(
                    f"{what} = {product}: '{name}' is not a number and not a scalar of the file"
                    f"{suggestion(name, self.scalars)}"
                ) from None
        if not math.isfinite(value):
            raise UsageError(f"{what} = {product}: expected a finite number, got {value}")
        return value

    def column(self, name: str) -> Array:
        """Return the numbers (n,) of a column; raise RecordingError when it holds none."""
        if name in self.faults:
            raise RecordingError(f"{self.path}: column '{name}': {self.faults[name]}")
        if name in self.texts:
            raise RecordingError(
                f"{self.path}: column '{name}', row {self.row(0)}: expected a number, got "
                f"'{self.texts[name][0][:40]}'"
            )
        return self.numbers[name]
