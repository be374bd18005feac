"""Frequency response of sampled systems, and what is read from it.

python-control's ``stability_margins`` looks for roots of a polynomial of twice the order; loops
sampled much faster than their bandwidth put these so close together that it warns and falls back
to an interpolation. Here the response itself is evaluated, and its crossings are refined.
"""

from collections.abc import Callable
from typing import Any

import control
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from stickslip.servo.axis import Array

_SHARES = np.geomspace(1e-5, 1.0, 4001)[:-1]  # of half the sample rate


def frequency_response(system: control.StateSpace, f: Array | float) -> NDArray[np.complex128]:
    """Return the response, (n,) or (), of a discrete system of one input and output at f [Hz]."""
    return respond(system, np.exp(2j * np.pi * np.asarray(f) * system.dt))[..., 0, 0]


def respond(system: control.StateSpace, z: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the response of a discrete system at points z (...) as (..., outputs, inputs)."""
    points = z[..., None, None]
    states = np.linalg.solve(points * np.eye(system.nstates) - system.A, system.B + 0j * points)
    return np.asarray(system.C @ states + system.D)


def stability_margins(open_loop: control.StateSpace) -> tuple[float, float, float]:
    """Return gain crossover [Hz], phase margin [deg] and gain margin [dB] of a discrete open loop.

    Where there are several crossings, the phase margin nearest to 0 with its crossover, and the
    gain margin nearest to 0. NaN where the gain never crosses 1; infinite where the phase never
    crosses 180 deg.
    """

    def respond(f: Array | float) -> NDArray[np.complex128]:
        return frequency_response(open_loop, f)

    highest = 0.5 / open_loop.dt
    f = _SHARES * highest
    crossovers = _crossings(lambda f: np.log(np.abs(respond(f))), f)
    phases = np.degrees(np.angle(-respond(crossovers)))
    nearest = np.argmin(np.abs(phases)) if len(phases) else None
    axis = np.append(_crossings(lambda f: np.imag(respond(f)), f), highest)
    at_axis = np.real(respond(axis))
    gains = -at_axis[at_axis < -1e-9]
    margins = -20 * np.log10(gains)
    return (
        float("nan") if nearest is None else float(crossovers[nearest]),
        float("nan") if nearest is None else float(phases[nearest]),
        float(min(margins, key=abs, default=float("inf"))),
    )


def bandwidth(closed_loop: control.StateSpace) -> float:
    """Return where the gain of a discrete closed loop first falls to -3 dB [Hz], NaN if nowhere."""

    def excess(f: Array | float) -> Array:
        return np.asarray(np.abs(frequency_response(closed_loop, f)) - np.sqrt(0.5))

    found = _crossings(excess, _SHARES * 0.5 / closed_loop.dt)
    return float(found[0]) if len(found) else float("nan")


def _crossings(function: Callable[[Any], Any], f: Array) -> Array:
    """Return where a function of frequency changes its sign [Hz]."""
    negative = function(f) < 0.0  # a zero counts as positive, so that it is found once
    places = np.flatnonzero(negative[:-1] != negative[1:])
    return np.array([brentq(function, f[i], f[i + 1], xtol=1e-13, rtol=1e-14) for i in places])
