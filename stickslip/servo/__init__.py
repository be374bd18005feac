"""The axis, its velocity loop and filter, and the loops as systems of FMUs.

ControlError(ValueError)         no controller meets the specification
"""

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
    "LoopSpecification",
    "VelocityFilter",
    "VelocityLoop",
    "close_velocity_loop",
    "design_velocity_filter",
    "design_velocity_loop",
]
