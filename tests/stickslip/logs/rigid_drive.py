"""A drive whose motion and force are known exactly."""

import numpy as np

from stickslip.logs import Recording


def rigid_drive(n=4000, T_s=1e-3, m=3.0, b=20.0, F_c=4.0, delay=0.0, step=0.0) -> Recording:
    """A rigid drive under a sweep of exact derivatives; its force shows ``delay`` samples late."""
    t = np.arange(n) * T_s

    def motion(t):
        phase = 2 * np.pi * (0.4 * t + 0.25 * t**2)
        rate = 2 * np.pi * (0.4 + 0.5 * t)
        x = 0.02 * np.sin(phase)
        v = 0.02 * rate * np.cos(phase)
        a = 0.02 * (np.pi * np.cos(phase) - rate**2 * np.sin(phase))
        return x, v, a

    x, v, _ = motion(t)
    _, late_v, late_a = motion(t - delay * T_s)
    force = m * late_a + b * late_v + F_c * np.sign(late_v)
    shown = np.round(x / step) * step if step else x
    return Recording(t, shown, force, velocity=v, position_command=x, encoder_step=step)
