"""Which step and duration a linear system proposes."""

from __future__ import annotations

import math

import numpy as np

from stickslip.models.lti.system import LinearSystem

_STEPS = 100_000  # at most


def proposed(system: LinearSystem) -> tuple[float, float]:
    """Return step and duration [s]: powers of ten (samples, where it is discrete) by the poles."""
    poles = np.linalg.eigvals(system.A)
    if system.dt:
        moduli = np.abs(poles)
        rates = -np.log(moduli[moduli > 0.0]) / system.dt
        step = system.dt
    else:
        rates = -poles.real
        fastest = max(abs(poles), default=0.0)
        step = 10.0 ** math.floor(math.log10(0.3 / fastest)) if fastest > 0.0 else 1e-3
    slowest = min((r for r in abs(rates) if r > 1e-9 / step), default=0.01 / step)
    steps = 10 ** math.ceil(math.log10(min(max(5.0 / (slowest * step), 1.0), _STEPS)))
    return step, step * steps
