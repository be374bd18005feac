"""Velocity from a log of encoder positions, and how often a signal turns."""

from collections.abc import Mapping
from ctypes import CDLL, c_int64, c_void_p
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stickslip.fmi.toolchain import Platform, shared_library

Array = NDArray[np.float64]

CUTOFF = 117.0  # Low-pass of the measured velocity [Hz]


def smoothed(signal: Array, T_s: float, cutoff: float = CUTOFF) -> Array:
    """Return a log through a second-order Butterworth low-pass, forward and back: no phase lag.

    The signals (..., n) have a value each T_s seconds. The cut-off is that of the single pass [Hz].
    The bits are those of ``scipy.signal``, whose import takes as long as checking a log.
    """
    section, rest = _low_pass(cutoff, T_s)
    n = np.shape(signal)[-1]
    edge = min(9, n - 1)  # samples before and after, which are those inside turned about the end
    before = 2.0 * signal[..., :1] - signal[..., edge:0:-1]
    after = 2.0 * signal[..., -1:] - signal[..., -2 : -edge - 2 : -1]
    whole = np.concatenate([before, signal, after], axis=-1)
    for _ in range(2):
        whole = filter_by_section(section, whole, rest * whole[..., :1])[..., ::-1]
    return whole[..., edge : edge + n]


def filter_by_section(section: Array, signal: Array, state: Array | float = 0.0) -> Array:
    """Return signals (..., n) through a section b0 b1 b2 1 a1 a2 that begins in states (..., 2)."""
    result = np.array(signal, dtype=float, order="C")
    states = np.array(np.broadcast_to(state, (*result.shape[:-1], 2)), order="C")
    lines = result.reshape(-1, result.shape[-1])
    for one in zip(states.reshape(-1, 2), lines, strict=True):
        library().filter_in_place(*(a.ctypes.data for a in (section, *one)), result.shape[-1])
    return result


@cache
def library() -> CDLL:
    """Return the library of ``filter_by_section``, compiled on first use."""
    loaded = CDLL(str(section_library()))
    loaded.filter_in_place.argtypes = (c_void_p, c_void_p, c_void_p, c_int64)
    return loaded


def section_library(platform: Platform | None = None) -> Path:
    """Return the path of the library for a platform, by default this one."""
    code = {"section.c": Path(__file__).with_name("section.c").read_text(encoding="utf-8")}
    return shared_library("section", code, platform=platform)


@cache
def _low_pass(cutoff: float, T_s: float) -> tuple[Array, Array]:
    """Return the section, by the bilinear transform, and its state at rest at a signal of 1."""
    share = cutoff / (1.0 / T_s / 2.0)
    if not 0.0 < share < 1.0:
        raise ValueError(f"cut-off {cutoff:.6g} Hz; expected more than 0, below {0.5 / T_s:.6g} Hz")
    warped = 4.0 * np.tan(np.pi * share / 2.0)
    poles = warped * -np.exp(0.25j * np.pi * np.array([-1.0, 1.0]))
    gain = warped**2 * np.real(1.0 / np.prod(4.0 - poles))
    pole = ((4.0 + poles) / (4.0 - poles))[0]
    _, a1, a2 = np.convolve([1.0, -pole], [1.0, -pole.conj()]).real
    change = [2.0 * gain - a1 * gain, gain - a2 * gain]
    rest = np.linalg.solve([[1.0 + a1, -1.0], [a2, 1.0]], change)
    return np.array([gain, 2.0 * gain, gain, 1.0, a1, a2]), rest


def derivative(signal: Array, T_s: float) -> Array:
    """Return the derivative (n,) of a smooth signal, of fourth order but at its ends."""
    slope = np.gradient(signal, T_s)
    slope[2:-2] = (signal[:-4] - 8.0 * signal[1:-3] + 8.0 * signal[3:-1] - signal[4:]) / (
        12.0 * T_s
    )
    return np.asarray(slope)


def measured_velocity(x_enc: Array, T_s: float) -> Array:
    """Return the velocity (n,) [m/s] from encoder positions (n,) [m]: differences, smoothed."""
    return smoothed(np.gradient(x_enc, T_s), T_s)


def blended_velocity(x_enc: Array, F_m: Array, m: float, T_s: float) -> Array:
    """Return the velocity (n,) [m/s] that the encoder shows below ``CUTOFF``, and the force above.

    Fast motion between two steps of an encoder, such as the response to one of them, shows in the
    force alone: above the cut-off it is its integral over the mass. The motor force F_m (n,) [N]
    acts in the period that ends at the position x_enc (n,) [m]; m is the mass [kg].
    """
    by_force = np.cumsum(F_m - F_m.mean()) * T_s / m
    return measured_velocity(x_enc, T_s) + by_force - smoothed(by_force, T_s)


def level(p: Mapping[str, float], v: Array | float) -> Array:
    """Return g (k,) [N] at velocities (k,) [m/s]: F_c without F_s; ``delta`` is 1 if not given."""
    if "F_s" not in p:
        return np.full(np.shape(v), p["F_c"])
    rest = np.asarray(np.exp(-((np.asarray(np.abs(v)) / p["v_s"]) ** p.get("delta", 1.0))))
    return p["F_c"] + (p["F_s"] - p["F_c"]) * rest


def turns(x: Array, swing: float) -> int:
    """Return how often x (n,) turns after a change by more than a swing, in the unit of x."""
    count, way = 0, 0
    low = high = float(x[0])
    for value in x.tolist():
        low, high = min(low, value), max(high, value)
        if way >= 0 and high - value > swing:
            count, way, low = count + way, -1, value
        elif way <= 0 and value - low > swing:
            count, way, high = count - way, 1, value
    return count
