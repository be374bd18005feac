"""Designs the nominal velocity loop with python-control, and hands its matrices to an FMU.

ControlError(ValueError)   no controller meets the specification
"""

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
    "LoopSpecification",
    "VelocityLoop",
    "close_velocity_loop",
    "design_velocity_loop",
]
