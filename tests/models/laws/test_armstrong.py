"""Armstrong's model: break-away at any speed and rise of static friction."""

import numpy as np
import pytest
from scipy.optimize import brentq

F_S, F_C, K_T = 8.999, 5.999, 3.9162e5


@pytest.mark.parametrize("gamma", [0.0, 1e-3, 1.0, 1e5])
@pytest.mark.parametrize("v", [1e-6, 1e-3])
def test_break_away_is_where_the_spring_carries_static_friction(follow, gamma, v):
    """At a speed slow enough for time at rest to count and at one that is not, from d = -5 um."""
    start = -5e-6

    def lack(t: float) -> float:
        risen = t / (t + gamma) if gamma else 1.0
        return F_C + (F_S - F_C) * risen - K_T * (start + v * t)

    time = brentq(lack, 1e-12, 40e-6 / v, xtol=1e-15)
    steps = 7
    h = 2 * time / steps
    p = {"gamma": gamma, "d": start, "v_s": 1e3, "sigma_t": 0.0}
    found = follow("armstrong", h, np.full(steps, v), **p)
    most = K_T * (start + v * time)
    assert found["F_f"][-1] == pytest.approx(most, rel=1e-10)
    expected = K_T * time * (start + v * time / 2) + (steps * h - time) * most
    assert found["F_mean"].sum() * h == pytest.approx(expected, rel=1e-10)
