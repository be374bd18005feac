"""The velocity loop with a velocity filter and feedforward of inertia: beyond the paper.

The gains stay; the velocity comes from a Kalman filter, and the loop need not lag behind the
command. Figures: docs/decisions/0022-velocity-filter.md.
"""

from __future__ import annotations

from stickslip.servo.axis import Datasheet
from stickslip.servo.velocity_filter import FilterSpecification, design_velocity_filter
from stickslip.servo.velocity_loop import VelocityLoop

UNKNOWN_SHARE = 0.25
"""Standard deviation of the change of friction in a second, as a share of Coulomb friction."""


def with_velocity_filter(loop: VelocityLoop, datasheet: Datasheet, F_c: float) -> VelocityLoop:
    """Return a loop with the same gains, its velocity from a filter of encoder and motor force.

    Raises stickslip.servo.axis.ControlError when the loop is unstable with it. The disturbance that
    it assumes is proportional to the Coulomb friction F_c [N].
    """
    specification = FilterSpecification(
        datasheet.encoder_step, datasheet.force_noise, UNKNOWN_SHARE * F_c
    )
    return loop.changed(velocity_filter=design_velocity_filter(loop.axis, loop.T_s, specification))


def with_inertia(loop: VelocityLoop) -> VelocityLoop:
    """Return a loop with feedforward of the force that accelerates its mass."""
    return loop.changed(m_ff=loop.axis.m)
