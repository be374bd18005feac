"""What can go wrong."""

from stickslip.fmi.errors import Fault


class CosimError(Fault):
    """Any error of this package that the caller may want to catch."""


class FmuError(CosimError, ValueError):
    """The file is not an FMU that can be run here."""


class ConnectionFault(CosimError, ValueError):
    """A component, connection or exposed input cannot be."""


class ParameterError(CosimError, ValueError):
    """A start value does not exist, cannot be set, or not to this value."""


class SignalError(CosimError, ValueError):
    """An input signal is missing, of the wrong shape, or not finite."""


class ExperimentError(CosimError, ValueError):
    """Start, stop and step make no run, or an option of it is unknown."""


class LinearisationError(CosimError, ValueError):
    """An FMU or system has no states, or not those that are asked for."""


class SspError(CosimError, ValueError):
    """The file is not a readable system structure package."""


class SimulationError(CosimError, RuntimeError):
    """An FMU failed during a run; the simulation can be run again."""


class FmuCrashed(SimulationError):
    """An FMU ended the process it had for itself, or did not return; another can be started."""


class SharedSimulation(CosimError, RuntimeError):
    """A simulation is used by two threads at once, or by a process that was forked."""
