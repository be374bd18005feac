"""Friction at steady speeds: g(v) = F_c + (F_s - F_c) exp(-(|v| / v_s)^delta), equation (4)."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.servo.measurement import Array


def level(p: Mapping[str, float], v: Array | float) -> Array:
    """Return g (k,) [N] at velocities (k,) [m/s]; ``delta`` is the paper's 1 if not given.

    Without F_s, friction is F_c at each speed.
    """
    if "F_s" not in p:
        return np.full(np.shape(v), p["F_c"])
    return p["F_c"] + (p["F_s"] - p["F_c"]) * _rest(p, np.abs(v))


def slope(p: Mapping[str, float], v: Array | float) -> Array:
    """Return dg/dv (k,) [N s/m] at speeds (k,) [m/s] above 0."""
    delta = p.get("delta", 1.0)
    steep = delta / p["v_s"] * (np.asarray(v) / p["v_s"]) ** (delta - 1.0)
    return -(p["F_s"] - p["F_c"]) * steep * _rest(p, v)


def _rest(p: Mapping[str, float], v: Array | float) -> Array:
    return np.asarray(np.exp(-((np.asarray(v) / p["v_s"]) ** p.get("delta", 1.0))))
