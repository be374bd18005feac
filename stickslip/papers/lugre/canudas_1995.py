"""The experiments of the paper that introduced the LuGre model, run with its FMUs.

Source
------
C. Canudas de Wit, H. Olsson, K. J. Astrom, P. Lischinsky, "A new model for control of systems with
friction", IEEE Transactions on Automatic Control 40, 1995, figures 2 to 8. The paper does not
give the mean velocity of figure 3, the rates of figure 4 and the end of figures 5 and 7; they are
chosen here.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip import cosim
from stickslip.papers.lugre.phenomena import Contact
from stickslip.servo.measurement import Array

PARAMETERS = {
    "sigma_0": 1e5,
    "sigma_1": np.sqrt(1e5),
    "b": 0.4,
    "F_c": 1.0,
    "F_s": 1.5,
    "v_s": 1e-3,
    "delta": 2.0,
    "m": 1.0,
}
"""Table I of the paper; its sigma_2 is b, and the mass is 1 kg."""

FREQUENCIES = (1.0, 10.0, 25.0)
"""Of figure 3 [rad/s]."""
RATES = (0.1, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0)
"""Of figure 4 [N/s]."""
_V_S = PARAMETERS["v_s"]


def presliding(contact: Contact) -> tuple[Array, Array, Array]:
    """Return time [s], force [N] and displacement [m] (n,) of figure 2: 95 % of break-away."""
    step, top = 1e-3, 0.95 * PARAMETERS["F_s"]
    corners = ((0.0, 0.0), (10.0, top), (15.0, top), (35.0, -top), (40.0, -top))
    times, forces = zip(*corners, (60.0, top), (65.0, top), strict=True)
    t = np.arange(1, round(times[-1] / step) + 1) * step
    x, _ = contact.push(np.interp(t - 0.5 * step, times, forces), step)
    return t, np.interp(t, times, forces), x


def lag(contact: Contact, omega: float) -> tuple[Array, Array]:
    """Return velocity [m/s] and friction force [N] (n,) over one period of figure 3.

    The velocity is v_s (1.5 + cos(omega t)); the first value is at cos = 1.
    """
    n = 4000
    step = 2.0 * np.pi / omega / n
    v = _V_S * (1.5 + np.cos(omega * step * (np.arange(4 * n) + 0.5)))
    force, _ = contact.follow(v, step)
    return v[-n:], force[-n:]


def lag_width(v: Array, force: Array) -> float:
    """Return how much more friction [N] there is at 1.5 v_s accelerating than decelerating."""
    half = len(v) // 2
    middle = 1.5 * _V_S
    slower = np.interp(-middle, -v[:half], force[:half])
    return float(np.interp(middle, v[half:], force[half:]) - slower)


def break_away(contact: Contact, rate: float) -> float:
    """Return the largest friction force [N] of figure 4, under a force that rises at a rate."""
    step = min(1e-3, 1e-3 / rate)
    ramp = rate * step * np.arange(0.5, 2.0 / rate / step)
    return float(contact.push(np.asarray(ramp, dtype=np.float64), step)[1].max())


def stick_slip(contact: Contact) -> dict[str, Array]:
    """Return figures 5 and 6: a spring of 2 N/m whose end moves at 0.1 m/s pulls the mass."""
    spring = cosim.Function(lambda t, u: 2.0 * (0.1 * t - u["x"]), {"x": "m"}, {"F": "N"})
    return contact.couple(spring, 30.0, 5e-4)


def hunting(contact: Contact) -> dict[str, Array]:
    """Return figures 7 and 8: PID control of the position to 1 m with K_p 3, K_i 4, K_v 6."""

    def control(_: float, h: float, state: Array, u: Mapping[str, float]) -> tuple[Array, float]:
        error = 1.0 - u["x"]
        integral = state + h * error
        return integral, float(3.0 * error + 4.0 * integral[0] - 6.0 * u["v"])

    pid = cosim.Function(control, {"x": "m", "v": "m/s"}, {"F": "N"}, state=np.zeros(1))
    return contact.couple(pid, 110.0, 1e-3)


def period(time: Array, signal: Array) -> float:
    """Return the time [s] between the last two upward passages of the mean of a signal (n,)."""
    above = signal > 0.5 * (signal.max() + signal.min())
    upward = np.flatnonzero(~above[:-1] & above[1:])
    return float(time[upward[-1]] - time[upward[-2]])
