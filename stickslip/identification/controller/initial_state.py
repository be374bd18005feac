"""The initial state of a controller that was running before the log began.

Its integrals held a force then, and its low-pass a velocity. Both add to what it commands along the
log: the one stays, the other fades with tau_f.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.servo.measurement import Array

HELD, FADING = "F_held", "F_fading"
"""What the log began with, beside the gains of the controller FMU [N]."""


def initial_state(missing: Array, gains: Mapping[str, float], T_s: float) -> dict[str, float]:
    """Return what suits best a force (n,) [N] that a controller with empty memory lacks."""
    columns = np.column_stack([np.ones_like(missing), _fading(len(missing), gains, T_s)])
    held, fading = np.linalg.lstsq(columns, missing, rcond=None)[0]
    return {HELD: float(held), FADING: float(fading)}


def is_running(gains: Mapping[str, float]) -> bool:
    """Tell whether the log began with something in the controller's memory."""
    return HELD in gains


def memory_force(gains: Mapping[str, float], n: int, T_s: float) -> Array:
    """Return what the memory adds along the log (n,) [N]."""
    held, fading = gains.get(HELD, 0.0), gains.get(FADING, 0.0)
    return held + fading * _fading(n, gains, T_s)


def fmu_gains(gains: Mapping[str, float]) -> dict[str, float]:
    """Return what the controller FMU has a parameter for."""
    return {name: value for name, value in gains.items() if name not in (HELD, FADING)}


def _fading(n: int, gains: Mapping[str, float], T_s: float) -> Array:
    tau_f, T_s = gains.get("tau_f", 0.0), gains.get("T_s", T_s)
    fading: Array = np.exp(-T_s / max(tau_f, 1e-3 * T_s) * np.arange(n))
    return fading
