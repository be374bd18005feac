"""Units of measurement as exponents of the SI base units.

Source: FMI 2.0 section 2.2.2, FMI 3.0 section 2.4.3.
"""

from __future__ import annotations

from dataclasses import dataclass

from cosim.scaling import IDENTITY, Scaling

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Unit:
    """A unit: value in base units = factor * value + offset.

    Attributes
    ----------
    name : as the FMU writes it
    exponents : of ``BASE_UNITS``; None when the FMU does not say
    """

    name: str
    exponents: tuple[int, ...] | None = None
    factor: float = 1.0
    offset: float = 0.0

    def same_as(self, other: Unit) -> bool:
        """Whether a number means the same in both units."""
        if self.exponents is None or other.exponents is None:
            return self.name == other.name
        mine = (self.exponents, self.factor, self.offset)
        return mine == (other.exponents, other.factor, other.offset)

    def to(self, other: Unit) -> Scaling | None:
        """Return what turns a number in this unit into one in the other, None when nothing does.

        Nothing does where the units measure different things, or one does not say what it
        measures.
        """
        if self.same_as(other):
            return IDENTITY
        if self.exponents is None or self.exponents != other.exponents:
            return None
        return Scaling(self.factor / other.factor, (self.offset - other.offset) / other.factor)
