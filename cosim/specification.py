"""All that makes a simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from cosim.coupling import Coupling, Method
from cosim.record import Record
from cosim.simulation import Simulation

if TYPE_CHECKING:
    from cosim.system import System


@dataclass(frozen=True)
class Specification:
    """All that makes a simulation; pickles, so that each worker can prepare its own.

    The fields are the arguments of ``System.prepare``.
    """

    system: System
    step: float
    stop: float
    start: float = 0.0
    record: Record | tuple[str, ...] | None = None
    coupling: Coupling | Method = "gauss_seidel"
    constant_step: bool = False
    compiled: bool = False
    tolerance: float | None = None
    allow_nan: bool = False

    def prepare(self) -> Simulation:
        """Instantiate the FMUs."""
        return Simulation(self)
