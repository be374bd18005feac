"""Imports FMUs, couples them and steps whole runs in C. Knows no model.

>>> system = cosim.System("loop")
>>> system.add("drive", "drive.fmu", parameters={"m": 6.0})
>>> system.expose("u", "drive.u")
>>> with system.prepare(step=5e-4, stop=10.0) as simulation:
...     result = simulation.run(inputs={"u": 1.0})
>>> result["drive.v"]
"""

from cosim.container import write_fmu
from cosim.coupling import Adaptive, Coupling
from cosim.errors import (
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
from cosim.experiment import DefaultExperiment
from cosim.fmu import Fmu
from cosim.isolation.settings import Isolation
from cosim.record import Deviation, Record
from cosim.result import Result
from cosim.scaling import Link, Scaling, ValueMap
from cosim.scenario import Scenario
from cosim.signals import Signal, SineSweep, Table, Trapezoid
from cosim.simulation import Simulation
from cosim.specification import Specification
from cosim.ssp import read_ssp, variants, write_ssp
from cosim.system import System
from cosim.tables import read_tables
from cosim.units import Unit
from cosim.variables import Variable

__all__ = [
    "Adaptive",
    "ConnectionFault",
    "CosimError",
    "Coupling",
    "DefaultExperiment",
    "Deviation",
    "ExperimentError",
    "Fmu",
    "FmuCrashed",
    "FmuError",
    "Isolation",
    "Link",
    "ParameterError",
    "Record",
    "Result",
    "Scaling",
    "Scenario",
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
    "ValueMap",
    "Variable",
    "read_ssp",
    "read_tables",
    "variants",
    "write_fmu",
    "write_ssp",
]
