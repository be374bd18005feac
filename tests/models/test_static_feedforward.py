"""Static feedforward: Coulomb friction with a ramp, and its limit."""

from __future__ import annotations

import numpy as np
import pytest

from stickslip import cosim

H = 5e-4  # s


def force(fmus, v, F_in=None, **parameters):
    system = cosim.System()
    system.add("fmu", fmus / "static_feedforward.fmu", {"lead": 0.0, **parameters})
    inputs = {"v": v, "F_in": np.zeros(len(v)) if F_in is None else F_in}
    for name in inputs:
        system.expose(name, f"fmu.{name}")
    with system.prepare(step=H, stop=H * (len(v) - 1)) as simulation:
        return simulation.run(inputs=inputs)["fmu.F"]


def test_without_a_ramp_it_is_the_sign_of_the_velocity(fmus):
    v = 0.01 * np.sin(np.arange(500) * 0.05 + 0.02)
    found = force(fmus, v, v_t=1e-12, F_c=4.0)
    mean = np.append(v[0], (v[1:-1] + v[:-2]) / 2)
    np.testing.assert_array_equal(found[1:], 4.0 * np.sign(mean))


def test_in_the_ramp_it_is_proportional_and_beyond_it_differs_by_direction(fmus):
    assert force(fmus, np.full(5, 2e-4), v_t=1e-3, F_c=5.0)[-1] == pytest.approx(1.0)
    assert force(fmus, np.full(5, 0.1), asymmetry=0.2, F_c=5.0)[-1] == pytest.approx(6.0)
    assert force(fmus, np.full(5, -0.1), asymmetry=0.2, F_c=5.0)[-1] == pytest.approx(-4.0)
    assert force(fmus, np.full(5, 0.1), b=3.0, F_c=5.0)[-1] == pytest.approx(5.3)


def test_the_lead_moves_the_force_ahead(fmus):
    v = 0.01 * np.arange(200) * H
    found = force(fmus, v, v_t=1.0, F_c=1.0, lead=4e-3)
    np.testing.assert_allclose(found[2:], (v[1:-1] + v[:-2]) / 2 + 4e-3 * 0.01, rtol=1e-9)


def test_another_compensators_force_is_passed_on(fmus):
    v, other = np.full(50, 0.01), np.linspace(-1.0, 1.0, 50)
    alone, chained = force(fmus, v), force(fmus, v, other)
    np.testing.assert_allclose(chained[1:] - alone[1:], other[:-1], atol=1e-12)
