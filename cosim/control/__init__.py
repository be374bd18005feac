"""python-control and FMUs: designs the nominal velocity loop, linearises, measures responses.

ControlError(ValueError)         no controller meets the specification
LinearisationError(CosimError)   an FMU or system has not the states, inputs or outputs it needs
"""

from stickslip.cosim.control.errors import LinearisationError
from stickslip.cosim.control.linearise import linearise, nonlinear_system
from stickslip.cosim.control.sweep import MeasuredResponse, measure_response
from stickslip.servo.axis import Axis, ControlError
from stickslip.servo.velocity_filter import (
    FilterSpecification,
    VelocityFilter,
    design_velocity_filter,
)
from stickslip.servo.velocity_loop import (
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
