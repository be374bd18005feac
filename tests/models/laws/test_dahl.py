"""Dahl's law: closed forms of the steady cycle, any exponent, and its limits."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

SIGMA_0, F_C = 3.9162e5, 5.999
H = 5e-4  # s


def cycle(amplitude: float) -> np.ndarray:
    """Return the velocity of triangular cycles from one end to the other [m/s], 400 steps each."""
    speed = 2.0 * amplitude / (200 * H)
    first = np.full(100, speed)
    return np.concatenate([first, np.tile(np.repeat([-speed, speed], 200), 10)])


@pytest.mark.parametrize("amplitude", [30e-6, 10e-6])
def test_the_steady_cycle_has_the_closed_form(follow, amplitude):
    """F(A) = F_c tanh a; the loss is 4 F_c^2 / sigma_0 (a - tanh a), a = sigma_0 A / F_c."""
    a = SIGMA_0 * amplitude / F_C
    v = cycle(amplitude)
    found = follow("dahl", H, v)
    assert found["F_f"][-1] == pytest.approx(F_C * np.tanh(a), rel=1e-9)
    last = slice(-400, None)
    energy = float(np.sum(found["F_mean"][last] * v[last]) * H)
    assert energy == pytest.approx(4.0 * F_C**2 / SIGMA_0 * (a - np.tanh(a)), rel=1e-9)


@pytest.mark.parametrize("i", [0.0, 0.5, 0.999999, 1.000001, 1.5, 2.0])
@pytest.mark.parametrize("v", [1e-9, 1e-5, 1e-3])
def test_any_exponent_against_a_solver(follow, i, v):
    """From a force against the motion, over ways from far below to far above F_c / sigma_0."""
    start, steps = -3.0, 60

    def rate(_: float, F: np.ndarray) -> np.ndarray:
        r = 1.0 - F / F_C
        return SIGMA_0 * np.where(r > 0.0, np.abs(r) ** i, 0.0)

    ways = np.arange(steps + 1) * H * v
    tight = {"rtol": 1e-11, "atol": 1e-12, "max_step": ways[-1] / 2000}
    exact = solve_ivp(rate, (0.0, ways[-1]), [start], "LSODA", dense_output=True, **tight)
    found = follow("dahl", H, np.full(steps, v), i=i, F_d=start)
    tolerance = 2e-5 if i < 1.0 else 1e-7  # the solver's, at the kink where the force is F_c
    np.testing.assert_allclose(found["F_f"], exact.sol(ways)[0], atol=tolerance)
    for k in (0, 20, 59):
        mean, _ = quad(lambda x: float(exact.sol(x)[0]), ways[k], ways[k + 1], limit=50)
        assert found["F_mean"][k] == pytest.approx(mean / (H * v), abs=tolerance)


def test_exponent_0_is_an_elastic_spring_that_slips(follow):
    v = 1e-4 * np.concatenate([np.full(400, 1.0), np.full(700, -1.0), np.full(100, 1.0)])
    force, expected = 0.0, []
    for way in v * H:
        force = np.clip(force + SIGMA_0 * way, -F_C, F_C)
        expected.append(force)
    np.testing.assert_allclose(follow("dahl", H, v, i=0.0)["F_f"][1:], expected, atol=1e-11)


def test_lugre_without_damping_and_stribeck_is_dahl(follow):
    v = 0.01 * np.sin(np.arange(800) * 0.05) * np.cos(np.arange(800) * 0.003)
    lugre = follow("lugre", H, v, F_s=F_C, F_c=F_C, sigma_1=0.0)
    np.testing.assert_allclose(follow("dahl", H, v)["F_mean"], lugre["F_mean"], atol=2e-13)
