"""Armstrong's model: rising static friction, friction memory, rest, and its limits."""

import numpy as np
import pytest
from scipy.optimize import brentq

H = 5e-4  # s
F_S, F_C, V_S, K_T = 8.999, 5.999, 5.5697e-4, 3.9162e5


@pytest.mark.parametrize(("dwell", "force"), [(0.1, 6.272), (1.0, 7.499), (10.0, 8.726)])
def test_static_friction_rises_with_the_time_at_rest(follow, dwell, force):
    """F_c + (F_s - F_c) t / (t + gamma); pulled at 0.1 m/s it breaks away within 0.3 ms."""
    v = np.append(np.zeros(round(dwell / H)), np.full(2, 0.1))
    found = follow("armstrong", H, v)["F_f"][-1]
    assert found == pytest.approx(F_C + (F_S - F_C) * dwell / (dwell + 1.0), abs=6e-4)
    assert found == pytest.approx(force, abs=1e-3)


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


def test_friction_in_motion_is_that_of_the_velocity_4_ms_ago(follow):
    """Steps of 0.5 ms are 8 intervals of the memory: the mean over a step is exact."""
    t = np.arange(800) * H
    v = V_S * (1.5 + np.sin(2 * np.pi * 10.0 * t))
    past = np.append(np.zeros(8), v)[: len(v)]  # tau_L is 4 ms
    force = follow("armstrong", H, v, gamma=0.0, tau_L=4e-3)["F_mean"]
    expected = F_C + (F_S - F_C) / (1.0 + (past / V_S) ** 2)
    np.testing.assert_allclose(force[100:], expected[100:], rtol=1e-12)


def test_a_reversal_keeps_the_force_and_begins_a_new_rest(follow):
    """Of the rise there is what the delayed velocity left, and it grows with the new rest."""
    slow, gamma, n = 1e-4, 0.1, 900  # m/s, s
    v = np.append(np.full(400, 1e-3), np.full(n, -slow))
    found = follow("armstrong", H, v, sigma_t=0.0, gamma=gamma)["F_f"][400:]
    share = (found[0] - F_C) / (F_S - F_C)

    def static(t: float) -> float:
        return F_C + (F_S - F_C) * (share + (1.0 - share) * t / (t + gamma))

    time = brentq(lambda t: static(t) + found[0] - K_T * slow * t, 0.0, 1.0)
    t = H * np.arange(n + 1)
    slides = F_C + (static(time) - F_C) / (1.0 + (slow / V_S) ** 2)
    expected = np.where(t < time, found[0] - K_T * slow * t, -slides)
    assert 0.02 < share < 0.1
    assert 0.3 < time < 0.4
    np.testing.assert_allclose(found, expected, rtol=1e-10)


@pytest.mark.parametrize("u", [2.9, -2.9])
def test_below_coulomb_friction_it_rests_on_a_spring(push, u):
    """A load that comes at once is at most doubled by the spring."""
    found = push("armstrong", H, np.full(4000, u))
    assert found["x"][-1] == pytest.approx(u / K_T, rel=1e-9)
    assert abs(found["v"][-1]) < 1e-12
    assert found["F_f"][-1] == pytest.approx(u, rel=1e-9)
