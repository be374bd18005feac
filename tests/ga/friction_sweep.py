"""A cheap problem of the real one's shape: the force of a LuGre bristle over a velocity sweep.

Five positive genes, searched over 0.1 .. 100 times a coarse start. The cost sees F_c strongly,
sigma_0 and sigma_1 moderately, F_s and v_s hardly; F_s >= F_c must hold.
"""

from dataclasses import dataclass
from itertools import accumulate

import numpy as np

from stickslip import ga

NAMES = ("F_s", "F_c", "v_s", "sigma_0", "sigma_1")
UNITS = ("N", "N", "m/s", "N/m", "N s/m")
TRUTH = np.array([8.999, 5.999, 5.5697e-4, 3.9162e5, 4.4248e3])
COARSENESS = np.array([0.3, 0.1, 0.8, 0.3, 0.5])
REPAIR = ga.AtLeast("F_s", "F_c")

_STEP = 4e-3
_TIME = np.arange(0, 2.5, _STEP)
_FREQUENCY = 0.1 * 50 ** (_TIME / 2.5)
_VELOCITY = 0.035 * np.sin(2 * np.pi * _FREQUENCY * 2.5 / np.log(50))


def force(values: np.ndarray) -> np.ndarray:
    """Friction force (N) over the sweep, with the bristle's exact step."""
    F_s, F_c, v_s, sigma_0, sigma_1 = values
    g = F_c + (F_s - F_c) * np.exp(-np.abs(_VELOCITY) / v_s)
    rate = sigma_0 * np.abs(_VELOCITY) / g
    decay = np.exp(-rate * _STEP)
    gain = np.where(rate > 0, -np.expm1(-rate * _STEP) / np.maximum(rate, 1e-300), _STEP)
    pairs = zip(decay.tolist(), (_VELOCITY * gain).tolist(), strict=True)
    z = np.array(list(accumulate(pairs, lambda z, p: z * p[0] + p[1], initial=0.0))[1:])
    return sigma_0 * z + sigma_1 * (_VELOCITY - rate * z)


_TRUE_FORCE = force(TRUTH)


@dataclass(frozen=True)
class ForceError:
    """Squared force error, relative to no compensation at all."""

    def __call__(self, values: np.ndarray) -> float:
        error = force(values) - _TRUE_FORCE
        return float(error @ error / (_TRUE_FORCE @ _TRUE_FORCE))


def genes(seed: int) -> list[ga.Gene]:
    """Genes around a coarse identification that differs from seed to seed."""
    rng = np.random.default_rng(1000 + seed)
    start = TRUTH * np.exp(COARSENESS * rng.standard_normal(5))
    start[0] = max(start[0], start[1])
    return [
        ga.Gene(name, 0.1 * value, 100 * value, value, unit)
        for name, value, unit in zip(NAMES, start.tolist(), UNITS, strict=True)
    ]
