"""Coarse starts: learning that does not begin at what identification found, but near it.

The paper identifies its drive "coarsely" and does not say how coarsely. Here the three experiments
find Coulomb friction to 0.02 %, so there is nothing to learn. A coarse start multiplies what they
found by factors, which stand for experiments of a stated accuracy.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.catalog.parameters import LUGRE, friction_law
from stickslip.identification.stages import Estimate

SPREAD = {name: one.spread for name, one in friction_law().parameters.items() if one.spread}
"""Standard deviation of the natural logarithm of each factor, from law.toml: "coarsely".

Forces to 20 %, as single slow runs show them; the two presliding parameters to a factor of 1.4;
the Stribeck velocity, which no single experiment isolates, to a factor of 2.
"""


def draw_factors(seed: int, width: float = 1.0) -> dict[str, float]:
    """Draw log-normal factors by name, as accurate as ``SPREAD`` times ``width``."""
    rng = np.random.Generator(np.random.PCG64(seed))
    logs = rng.standard_normal(len(LUGRE)) * [width * SPREAD[name] for name in LUGRE]
    return dict(zip(LUGRE, np.exp(logs).tolist(), strict=True))


def coarsened(
    estimates: Mapping[str, Estimate], factors: Mapping[str, float]
) -> dict[str, Estimate]:
    """Return the five estimates times factors, with standard errors of ``SPREAD``.

    Static friction below Coulomb friction, which no experiment would report, is exchanged with it.

    Parameters
    ----------
    factors : by name; a missing one is 1
    """
    values = {name: estimates[name].value * factors.get(name, 1.0) for name in LUGRE}
    low, high = sorted((values["F_c"], values["F_s"]))
    values |= {"F_c": low, "F_s": high}
    return {name: Estimate(value, SPREAD[name] * value) for name, value in values.items()}
