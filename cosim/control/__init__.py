"""python-control and FMUs: designs the nominal velocity loop, linearises, measures responses.

ControlError(ValueError)         no controller meets the specification
LinearisationError(CosimError)   an FMU or system has not the states, inputs or outputs it needs
"""

from cosim.control.axis import Axis, ControlError
from cosim.control.errors import LinearisationError
from cosim.control.linearise import linearise, nonlinear_system
from cosim.control.sweep import MeasuredResponse, measure_response
from cosim.control.velocity_filter import (
    FilterSpecification,
    VelocityFilter,
    design_velocity_filter,
)
from cosim.control.velocity_loop import (
    LoopSpecification,
    VelocityLoop,
    close_velocity_loop,
    design_velocity_loop,
)

__all__ = [
    "Axis",
    "ControlError",
    "FilterSpecification",
    "LinearisationError",
    "LoopSpecification",
    "MeasuredResponse",
    "VelocityFilter",
    "VelocityLoop",
    "close_velocity_loop",
    "design_velocity_filter",
    "design_velocity_loop",
    "linearise",
    "measure_response",
    "nonlinear_system",
]
