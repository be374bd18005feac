"""A PI controller tuned against friction, as the reference without any compensator."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from stickslip.servo.measurement import Array
from stickslip.servo.velocity_loop import VelocityLoop, close_velocity_loop

FREQUENCIES = 2000
"""Points at which the sensitivity is evaluated, evenly spaced in the logarithm of the frequency."""


def tuned_pi(loop: VelocityLoop) -> VelocityLoop:
    """Return the loop whose PI gains reject friction best at the peak sensitivity of another.

    Friction acts like a step of force where the motion reverses, and the integral of the error that
    a step leaves is 1 / K_i. So K_i is the largest for which no frequency is amplified more than
    in ``loop``.

    Source: Astrom and Hagglund, Advanced PID Control, ISA 2006, section 6.2 (integral gain
    optimisation).
    """
    z = _points(loop)
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


def _points(loop: VelocityLoop) -> Array:
    """Return e^(j w T_s) at frequencies (n,) from 0.1 Hz to half the sample rate."""
    half = 0.5 / loop.T_s
    frequencies = np.geomspace(0.1, 0.999 * half, FREQUENCIES)
    return np.asarray(np.exp(2j * np.pi * frequencies * loop.T_s))
