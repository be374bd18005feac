"""Imports FMUs, couples them and steps whole runs in C. Knows no model.

>>> system = cosim.System("loop")
>>> system.add("drive", "drive.fmu", parameters={"m": 6.0})
>>> system.expose("u", "drive.u")
>>> with system.prepare(step=5e-4, stop=10.0) as simulation:
...     result = simulation.run(inputs={"u": 1.0})
>>> result["drive.v"]
"""

from importlib import import_module
from typing import TYPE_CHECKING

from stickslip.cosim.component import Component
from stickslip.cosim.errors import (
    ConnectionFault,
    CosimError,
    ExperimentError,
    FmuCrashed,
    FmuError,
    ParameterError,
    SharedSimulation,
    SignalError,
    SimulationError,
    SspError,
)
from stickslip.cosim.fmu.fmu import Fmu
from stickslip.cosim.function import Function
from stickslip.cosim.run.result import Result
from stickslip.cosim.run.simulation import Simulation
from stickslip.cosim.signals.signals import Signal, SineSweep, Table, Trapezoid
from stickslip.cosim.signals.tables import read_tables, signals_of
from stickslip.cosim.system.scaling import Link, Scaling
from stickslip.cosim.system.settings import Adaptive, Coupling, Isolated, Isolation, Record
from stickslip.cosim.system.system import Specification, System
from stickslip.fmi.description.model import DefaultExperiment
from stickslip.fmi.description.units import Unit
from stickslip.fmi.description.variables import Variable

if TYPE_CHECKING:  # loaded when they are first used, for those who start quickly
    from stickslip.cosim.container import write_fmu
    from stickslip.cosim.ssp import read_ssp, variants, write_ssp

__all__ = [
    "Adaptive",
    "Component",
    "ConnectionFault",
    "CosimError",
    "Coupling",
    "DefaultExperiment",
    "ExperimentError",
    "Fmu",
    "FmuCrashed",
    "FmuError",
    "Function",
    "Isolated",
    "Isolation",
    "Link",
    "ParameterError",
    "Record",
    "Result",
    "Scaling",
    "SharedSimulation",
    "Signal",
    "SignalError",
    "Simulation",
    "SimulationError",
    "SineSweep",
    "Specification",
    "SspError",
    "System",
    "Table",
    "Trapezoid",
    "Unit",
    "Variable",
    "read_ssp",
    "read_tables",
    "signals_of",
    "variants",
    "write_fmu",
    "write_ssp",
]

_LATE = {"write_fmu": "container"} | dict.fromkeys(("read_ssp", "variants", "write_ssp"), "ssp")


def __getattr__(name: str) -> object:
    """Import what packs systems and reads packages when it is first used."""
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = globals()[name] = getattr(import_module(f"{__name__}.{_LATE[name]}"), name)
    return value
