"""All that makes a simulation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from stickslip.cosim.isolation.settings import Isolation
from stickslip.cosim.isolation.simulation import IsolatedSimulation
from stickslip.cosim.run.simulation import Simulation
from stickslip.cosim.system.coupling import Coupling, Method
from stickslip.cosim.system.record import Record

if TYPE_CHECKING:
    from stickslip.cosim.system.system import System


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
    isolation: Isolation | Literal["process"] | None = None

    def prepare(self) -> Simulation:
        """Instantiate the FMUs, here or in a process of their own."""
        limits = Isolation.of(self.isolation)
        return Simulation(self) if limits is None else IsolatedSimulation(self, limits)
