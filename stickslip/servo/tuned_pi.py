"""A PI controller tuned against friction, as the reference without any compensator."""

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from stickslip.servo.axis import Datasheet
from stickslip.servo.velocity_filter import FilterSpecification, design_velocity_filter
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop

FREQUENCIES = 2000  # frequencies of the sensitivity, evenly spaced in the logarithm


def tuned_pi(loop: VelocityLoop) -> VelocityLoop:
    """Return the loop whose PI gains reject friction best at the peak sensitivity of another.

    Friction acts like a step of force where the motion reverses, and the integral of the error that
    a step leaves is 1 / K_i. So K_i is the largest for which no frequency is amplified more than
    in ``loop``.

    Source: Astrom and Hagglund, Advanced PID Control, ISA 2006, section 6.2 (integral gain
    optimisation).
    """
    frequencies = np.geomspace(0.1, 0.999 * 0.5 / loop.T_s, FREQUENCIES)  # [Hz]
    z = np.exp(2j * np.pi * frequencies * loop.T_s)
    limit = float(np.abs(1.0 / (1.0 + loop.open_loop(z))).max())
    integrator = loop.T_s * z / (z - 1.0)
    plant = loop.open_loop(z) / (loop.K_p + loop.K_i * integrator)

    def excess(K_i: float, K_p: float) -> float:
        sensitivity = 1.0 / (1.0 + plant * (K_p + K_i * integrator))
        return float(np.abs(sensitivity).max()) - limit

    def largest(K_p: float) -> float:
        if excess(0.0, K_p) >= 0.0:
            return 0.0
        high = loop.K_i
        while excess(high, K_p) < 0.0:
            high *= 2.0
        return float(brentq(excess, 0.0, high, (K_p,), xtol=1e-3))

    bounds = (0.2 * loop.K_p, loop.K_p * 2.0)
    found = minimize_scalar(lambda K_p: -largest(K_p), bounds=bounds, method="bounded")
    return close_velocity_loop(
        loop.axis, loop.T_s, loop.tau_f, float(found.x), K_i=-float(found.fun)
    )


UNKNOWN_SHARE = 0.25  # deviation of the change of friction in 1 s, over Coulomb friction


def with_velocity_filter(loop: VelocityLoop, datasheet: Datasheet, F_c: float) -> VelocityLoop:
    """Return a loop with the same gains, its velocity from a filter of encoder and motor force.

    The gains stay; the velocity comes from a Kalman filter, and the loop need not lag behind the
    command. Figures: docs/decisions/0022-velocity-filter.md.

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
