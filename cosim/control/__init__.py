"""python-control and FMUs: designs the nominal velocity loop, linearises, measures responses.

ControlError(ValueError)         no controller meets the specification
LinearisationError(CosimError)   an FMU or system has not the states, inputs or outputs it needs
"""

from cosim.control.errors import LinearisationError
from cosim.control.linearise import linearise, nonlinear_system
from cosim.control.sweep import MeasuredResponse, measure_response
from cosim.control.velocity_loop import (
    Axis,
    ControlError,
    LoopSpecification,
    VelocityLoop,
    close_velocity_loop,
    design_velocity_loop,
)

__all__ = [
    "Axis",
    "ControlError",
    "LinearisationError",
    "LoopSpecification",
    "MeasuredResponse",
    "VelocityLoop",
    "close_velocity_loop",
    "design_velocity_loop",
    "linearise",
    "measure_response",
    "nonlinear_system",
]
