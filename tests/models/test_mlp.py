"""The multilayer network: its function, what one error changes, and friction that it learns."""

from __future__ import annotations

import numpy as np

T = 5e-4  # s
W = [(i, j) for i in range(1, 9) for j in range(1, 5)]


def test_one_unit_alone_is_a_hyperbolic_tangent_of_the_displacement(network):
    v = np.full(200, 0.01)
    off = {f"w_0[{i},{j}]": 0.0 for i, j in W}
    one = {"w_0[3,2]": 1.5, "w_0[3,3]": 0.2, "w_0[3,4]": 0.5}
    weights = {"gamma": 0.0, "q_0": 1e-4, "F_max": 8.0, **off, **one}
    found = network("mlp", v, np.zeros(200), **weights)["fmu.F"]
    q = (np.arange(199) + 0.5) * 0.01 * T
    np.testing.assert_allclose(found[1:], 4.0 * np.tanh(1.5 * (q - 1e-4) / (q + 1e-4) + 0.2))


def test_one_error_moves_the_force_there_by_its_share(network):
    """To first order of a small step, where the motion stays at one place."""
    v = np.full(800, 0.05)
    lack = 5.0 - network("mlp", v, np.full(800, 5.0), gamma=0.02, D=0, q_0=1e-12)["fmu.F"]
    np.testing.assert_allclose(lack[3:], lack[2:-1] - 0.02 * lack[1:-2], atol=2e-3)
    assert abs(lack[-1]) < 1e-3


def test_it_learns_hysteresis_that_velocity_alone_does_not_tell(network):
    """Coulomb friction with a presliding distance of 20 um, learned from its force itself."""
    v = 0.02 * np.sin(2 * np.pi * np.arange(12000) * T)
    x = np.append(0.0, np.cumsum((v[1:] + v[:-1]) / 2) * T)
    friction = [0.0]
    for way in np.diff(x):  # Jenkins element
        friction.append(np.clip(friction[-1] + 2 * 6.0 / 2e-5 * way, -6.0, 6.0))
    lost = np.append(friction[1:], 0.0)  # u of the period that ends when the next sample is taken
    F = network("mlp", v, np.append(0.0, lost[:-1]), gamma=0.05, D=0)["fmu.F"]
    error = (F - friction)[-4000:]
    assert np.sqrt(np.mean(error**2)) < 0.1 * np.sqrt(np.mean(np.square(friction)))


def test_a_weight_stays_within_its_limit(network):
    result = network("mlp", np.full(600, 0.05), np.full(600, 1e4), gamma=1.0, D=0)
    w = {place: result[f"fmu.w[{place[0]},{place[1]}]"] for place in W}
    assert max(np.abs(w[place]).max() for place in W if place[1] == 4) == 1.0
    assert max(np.abs(w[place]).max() for place in W if place[1] != 4) == 20.0
