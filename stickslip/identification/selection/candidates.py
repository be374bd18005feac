"""The friction laws of the catalogue that a recording may be explained by."""

from __future__ import annotations

from dataclasses import dataclass

from stickslip import models
from stickslip.catalog.parameters import friction_law, presliding
from stickslip.catalog.space import ParameterSpace
from stickslip.models import Law


@dataclass(frozen=True)
class Candidate:
    """A friction law, or its case in which friction does not rise towards rest."""

    law: Law  # of the catalogue
    # whether each parameter with a lower bound, as F_s, is held there, as at F_c
    is_level: bool = False

    @property
    def title(self) -> str:
        """The name for people."""
        return "Coulomb-viscous" if self.is_level else self.law.title

    def restricted(self, space: ParameterSpace) -> ParameterSpace:
        """Return the space in which this candidate is estimated."""
        return space.level() if self.is_level else space


def candidates() -> tuple[Candidate, ...]:
    """Return Coulomb and viscous friction alone, then the laws with ``candidate``, LuGre first.

    Coulomb-viscous is the level case of a law that has a static curve and no presliding.
    """
    every = map(friction_law, dict.fromkeys(("lugre", *models.law_names())))
    laws = [law for law in every if law.is_candidate]
    static = [law for law in laws if not presliding(law) and ParameterSpace.of(law).bounded]
    return (*(Candidate(law, is_level=True) for law in static[:1]), *map(Candidate, laws))
