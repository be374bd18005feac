"""The cost of a run from a file: weighted mean squares of signals against references.

[[signal]]
name = "axis.x"             # of a variable or an exposed input
reference = "x_cmd"         # the same, or a number; 0 by default
weight = 1.0                # 1 by default
window = [0.2, 1.0]         # in s; the whole run by default
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stickslip import cosim
from stickslip.errors import UsageError
from stickslip.toml_files import NUMBER, PAIR, TEXT, checked, is_number, read_toml

KINDS = {
    "name": TEXT,
    "reference": (lambda value: is_number(value) or isinstance(value, str), "a name or a number"),
    "weight": NUMBER,
    "window": PAIR,
}


@dataclass(frozen=True)
class WeightedSignal:
    """A signal that counts."""

    name: str
    reference: str | float = 0.0
    weight: float = 1.0
    window: tuple[float, float] = (-np.inf, np.inf)  # [s]


@dataclass(frozen=True)
class SignalCost:
    """The sum of weighted mean squares of signals less their references."""

    signals: Sequence[WeightedSignal]

    @property
    def record(self) -> list[str]:
        """Names of what a run has to record."""
        names = [name for one in self.signals for name in (one.name, one.reference)]
        return [*dict.fromkeys(name for name in names if isinstance(name, str))]

    def __call__(self, result: cosim.Result) -> float:
        """Return the cost of a run; raise UsageError where a window has no sample."""
        total = 0.0
        for one in self.signals:
            low, high = one.window
            inside = (result.time >= low) & (result.time <= high)
            if not inside.any():
                raise UsageError(f"{one.name}: no sample of the run lies in {low:g} to {high:g} s")
            reference = one.reference
            other = result[reference] if isinstance(reference, str) else reference
            total += one.weight * float(np.mean(np.square(result[one.name] - other)[inside]))
        return total


def read_cost(path: Path) -> SignalCost:
    """Read a cost file; raise UsageError when it cannot be read, or is not one."""
    tables = read_toml(path)
    entries = tables.get("signal")
    try:
        checked(tables, {"signal": (lambda value: isinstance(value, list), "tables [[signal]]")})
        found = [WeightedSignal(**checked(one, KINDS, "signal.")) for one in entries or ()]
    except (TypeError, AttributeError, UsageError) as error:
        raise UsageError(f"{path}: {error}; expected tables [[signal]], each with name") from None
    if not found or min(one.weight for one in found) < 0.0:
        raise UsageError(f"{path}: expected one [[signal]] or more, with weights of 0 or more")
    return SignalCost(found)
