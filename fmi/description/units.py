"""Units of measurement as exponents of the SI base units.

Source: FMI 2.0 section 2.2.2, FMI 3.0 section 2.4.3.
"""

from dataclasses import dataclass, replace
from typing import Self

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Unit:
    """A unit: value in base units = factor * value + offset.

    ``relative`` tells whether it measures differences (relativeQuantity of FMI), to which no offset
    applies; None where that is not said, as of units in SSP: then it is as at the other end.
    """

    name: str  # as the FMU writes it
    exponents: tuple[int, ...] | None = None  # of ``BASE_UNITS``; None when the FMU does not say
    factor: float = 1.0
    offset: float = 0.0
    relative: bool | None = None

    def __str__(self) -> str:
        """Return its name for messages."""
        return repr(self.name) + (" as a difference (relativeQuantity)" if self.relative else "")

    def like(self, other: Self | None) -> Self:
        """Return it as measuring differences or not, as another one does, where it does not say."""
        silent = self.relative is None
        return replace(self, relative=other.relative) if other and silent else self

    def same_as(self, other: Self) -> bool:
        """Whether a number means the same in both units."""
        if self.exponents is None or other.exponents is None:
            return self.name == other.name
        mine = (self.exponents, self.factor, self.offset)
        return mine == (other.exponents, other.factor, other.offset)

    def measures_as(self, other: Self) -> bool:
        """Whether both are known to measure the same thing."""
        return self.exponents is not None and self.exponents == other.exponents
