"""What is learned: one parameter, its search range and where to start."""

from __future__ import annotations

import math
from dataclasses import dataclass

from stickslip.ga.errors import SettingsError


@dataclass(frozen=True)
class Gene:
    """One parameter that the algorithm may change.

    Parameters
    ----------
    name : what the parameter is called where it is used, e.g. ``compensator.F_c``
    lower, upper : bounds of the search, in `unit`
    start : the coarsely identified value, in `unit`
    unit : for people and reports
    linear : search its values evenly even where other genes are logarithmic, e.g. an offset that
        may be negative

    Raises
    ------
    SettingsError : a value is not finite, the bounds are out of order or exclude the start
    """

    name: str
    lower: float
    upper: float
    start: float
    unit: str = ""
    linear: bool = False

    def __post_init__(self) -> None:
        values = {"lower": self.lower, "upper": self.upper, "start": self.start}
        for field, value in values.items():
            if not math.isfinite(value):
                raise SettingsError(f"gene {self.name}: {field} must be finite, got {value}")
        if not self.lower < self.upper:
            raise SettingsError(
                f"gene {self.name}: lower must be below upper, got {self.lower} and {self.upper}"
            )
        if not self.lower <= self.start <= self.upper:
            raise SettingsError(
                f"gene {self.name}: start {self.start} is outside its bounds "
                f"{self.lower} .. {self.upper}; widen them or move the start"
            )
