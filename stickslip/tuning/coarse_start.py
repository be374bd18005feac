"""Coarse starts: learning that does not begin at what identification found, but near it.

The paper identifies its drive "coarsely" and does not say how coarsely. Here the three experiments
find Coulomb friction to 0.02 %, so there is nothing to learn. A coarse start multiplies what they
found by factors, which stand for experiments of a stated accuracy.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from stickslip.catalog.parameters import estimated, friction_law
from stickslip.catalog.space import ParameterSpace
from stickslip.identification.stages import Estimate
from stickslip.models import Law


def spread_of(law: Law) -> dict[str, float]:
    """Return the standard deviations by name of the logarithms of factors for a law."""
    return {name: law.parameters[name].spread or 0.0 for name in estimated(law)}


SPREAD = spread_of(friction_law())
"""Standard deviation of the natural logarithm of each factor, from law.toml: "coarsely".

Forces to 20 %, as single slow runs show them; the two presliding parameters to a factor of 1.4;
the Stribeck velocity, which no single experiment isolates, to a factor of 2.
"""


def draw_factors(seed: int, width: float = 1.0) -> dict[str, float]:
    """Draw log-normal factors by name, as accurate as ``SPREAD`` times ``width``."""
    rng = np.random.Generator(np.random.PCG64(seed))
    logs = rng.standard_normal(len(SPREAD)) * [width * one for one in SPREAD.values()]
    return dict(zip(SPREAD, np.exp(logs).tolist(), strict=True))


def coarsened(
    estimates: Mapping[str, Estimate], factors: Mapping[str, float], law: Law | None = None
) -> dict[str, Estimate]:
    """Return the estimates of a law's parameters times factors, with standard errors of ``SPREAD``.

    Static friction below Coulomb friction, which no experiment would report, is exchanged with it.

    Parameters
    ----------
    factors : by name; a missing one is 1
    """
    law = law or friction_law()
    spread = spread_of(law)
    values = {name: estimates[name].value * factors.get(name, 1.0) for name in spread}
    for name, bound in ParameterSpace.of(law).bounded.items():
        values[bound], values[name] = sorted((values[bound], values[name]))
    return {name: Estimate(value, spread[name] * value) for name, value in values.items()}
