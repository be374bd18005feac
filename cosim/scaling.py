"""Straight lines between the number at one end of a connection and the number at the other."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Scaling:
    """y = factor * x + offset.

    Attributes
    ----------
    factor : unit of y per unit of x
    offset : in the unit of y
    """

    factor: float = 1.0
    offset: float = 0.0

    def __call__(self, x: float) -> float:
        """Return y."""
        return x if self == IDENTITY else self.factor * x + self.offset

    def then(self, following: Scaling) -> Scaling:
        """Return the scaling that does this one first and ``following`` on its result."""
        if self == IDENTITY:
            return following
        factor = following.factor * self.factor
        return Scaling(factor, following(self.offset))

    def inverse(self, y: float) -> float:
        """Return the x that leads to y; the factor must not be 0."""
        return y if self == IDENTITY else (y - self.offset) / self.factor


IDENTITY = Scaling()


@dataclass(frozen=True)
class Link:
    """How a connection treats the number that it carries.

    Attributes
    ----------
    scaling : applied last, to the number in the unit of the target
    convert : whether the number is converted from the unit of the source before
    """

    scaling: Scaling = IDENTITY
    convert: bool = True


PLAIN = Link()
