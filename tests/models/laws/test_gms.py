"""Generalised Maxwell-slip: Masing's rules, closed minor loops, lag, and the limits of the law."""

import numpy as np
import pytest

from stickslip import models

H = 5e-4  # s
START = {name: np.array(p.start) for name, p in models.load_law("gms").parameters.items()}
K = START["sigma_0"] * START["kappa"] / START["kappa"].sum()  # [N/m]
W = START["F_s"] * START["alpha"] / START["alpha"].sum()  # [N] limits where g is F_s
MAXWELL = {"F_c": 8.999, "C": 1e12, "sigma_1": 0.0}  # g is constant, elements hold their limit
ONE = {
    **{f"{name}[{k}]": float(k == 1) for name in ("alpha", "kappa") for k in range(1, 5)},
    "sigma_1": 0.0,
    "C": 1e12,
    "F_s": 5.999,
}


def virgin(x: float) -> float:
    """Return the force [N] of Maxwell-slip elements after a first way x [m]."""
    return float(np.minimum(K * x, W).sum())


def path(ways: list[float]) -> np.ndarray:
    """Return velocities [m/s] for ways [m] of 100 steps each."""
    return np.repeat(ways, 100) / (100 * H)


def test_the_first_way_and_the_way_back_follow_masing(follow):
    """Back from +A the force is f(A) - 2 f((A - x) / 2)."""
    n, A = 100, 60e-6
    force = follow("gms", H, path([A, -2 * A]), **MAXWELL)["F_f"]
    x = np.arange(n + 1) / n * A
    np.testing.assert_allclose(force[: n + 1], [virgin(a) for a in x], atol=1e-9)
    back = [virgin(A) - 2.0 * virgin(a) for a in x]
    np.testing.assert_allclose(force[n:], back, atol=1e-9)


def test_minor_loops_close_and_are_wiped_out(follow):
    """0, 40, 0, 15, 0, -40 um: at the second 0 nothing is left of the loop to 15 um."""
    long = follow("gms", H, path([40e-6, -40e-6, 15e-6, -15e-6, -40e-6]), **MAXWELL)["F_f"]
    short = follow("gms", H, path([40e-6, -40e-6, -40e-6]), **MAXWELL)["F_f"]
    assert long[200] == pytest.approx(-3.891496087, abs=1e-4)  # stiffnesses rounded to 1 N/m
    assert long[400] == pytest.approx(long[200], abs=1e-9)
    np.testing.assert_allclose(long[400:], short[200:], atol=1e-9)


def test_one_element_is_an_elastic_spring_that_slips(follow):
    """GMS with one element, C without bound and no Stribeck effect is Dahl's law with i = 0."""
    v = 0.002 * np.sin(np.arange(600) * 0.05)
    gms = follow("gms", H, v, **ONE)
    dahl = follow("dahl", H, v, i=0.0)
    np.testing.assert_allclose(gms["F_mean"], dahl["F_mean"], atol=1e-9)


@pytest.mark.parametrize(
    ("C", "omega", "gap"),
    [(1500, 10, 0.060), (1500, 100, 0.540), (150, 10, 0.540), (150, 100, 0.307)],
)
def test_friction_lags_behind_the_velocity(follow, C, omega, gap):
    """About 1.5 v_s +- v_s: higher while accelerating than while decelerating, by C / omega."""
    v_s, h = float(START["v_s"][0]), 2e-5
    t = (np.arange(round((0.5 + 8 * np.pi / omega) / h)) + 0.5) * h
    v = v_s * (1.5 + np.sin(omega * t))
    force = follow("gms", h, v, C=float(C), sigma_1=0.0)["F_mean"]
    last = t > t[-1] - 2 * np.pi / omega
    rising = np.cos(omega * t) > 0.0
    at = [
        float(np.interp(1.5 * v_s, v[s][order], force[s][order]))
        for s in (last & rising, last & ~rising)
        for order in [np.argsort(v[s])]
    ]
    assert at[0] - at[1] == pytest.approx(gap, abs=1.5e-3)


def test_a_small_oscillating_load_does_not_move_it_for_ever(push):
    """2.4 + 1.6 sin(2 pi 5 t) N: LuGre drifts by 25.56 um/s, GMS stays."""
    t = np.arange(16000) * H
    u = 2.4 + 1.6 * np.sin(2 * np.pi * 5.0 * t)
    drift = {}
    for law in ("lugre", "gms"):
        x = push(law, H, u)["x"]
        drift[law] = (x[16000] - x[8000]) / 4.0
    assert drift["lugre"] == pytest.approx(25.56e-6, rel=2e-3)
    assert abs(drift["gms"]) < 1e-9
